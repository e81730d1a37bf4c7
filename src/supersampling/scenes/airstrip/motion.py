"""Courses around the airstrip's middle."""

import numpy as np

from supersampling.scenes.kit.course import Course
from supersampling.scenes.kit.skins import outline

GRAVITY = 9.81


def lane(a: float, b: float, low: float, high: float, waves: int = 2) -> Course:
    """Return a course around the middle on a superellipse, its height between ``low`` and ``high``."""
    flat = outline(a, b, 24, 0.8)
    wave = 0.5 + 0.5 * np.sin(2 * np.pi * waves * np.arange(24) / 24)
    return Course(np.stack([flat[:, 0], low + (high - low) * wave, flat[:, 1]], 1))
