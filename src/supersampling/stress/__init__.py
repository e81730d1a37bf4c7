"""Tests of every model at the ends of what its inputs, gates and number formats allow (docs/stress.md)."""
