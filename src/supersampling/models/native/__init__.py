"""DLCTUS in C++ for CPUs, compiled on first use; without a compiler, PyTorch's operations compute the same."""
