"""The atrium: the courtyard of a library, between two colonnades, open to the sky."""

from .atrium import atrium

__all__ = ["atrium"]
