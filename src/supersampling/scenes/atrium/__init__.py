"""The built-in scene ``atrium``: the courtyard of a library, between two colonnades, open to the sky."""

from supersampling.scenes.atrium.atrium import atrium

__all__ = ["atrium"]
