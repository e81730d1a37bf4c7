"""Passes in C++ for processors, compiled on first use; PyTorch's own operations do the same where there is no compiler."""
