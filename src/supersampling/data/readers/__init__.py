"""Readers of captures that users own: QRISP, NSRD and Arm NSS layouts into data set files (`importing`)."""
