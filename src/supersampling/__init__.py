"""Train, ablate, compare and trust neural supersampling methods."""

__version__ = "0.1.0"
