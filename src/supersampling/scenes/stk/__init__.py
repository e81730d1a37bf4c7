"""SuperTuxKart's tracks as scenes, from the data of Debian's package ``supertuxkart-data``."""

from supersampling.scenes.stk.data import available_tracks, find_data, track_folder
from supersampling.scenes.stk.track import load_track

__all__ = ["available_tracks", "find_data", "load_track", "track_folder"]
