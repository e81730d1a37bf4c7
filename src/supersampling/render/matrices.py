"""Projections and camera rays of a window: float64, for column vectors.

The renderer's clip space has y pointing DOWN, so that row 0 of a framebuffer is the top row of the image and
``uv = ndc / 2 + 1/2`` needs no flip. Front faces are therefore clockwise on screen.
"""

import numpy as np

from supersampling.render.camera import Camera, Matrix, Window


def full_projection(camera: Camera, window: Window, near: float, far: float) -> Matrix:
    """Return the perspective ``(4, 4)`` of the whole frame around ``window``; ``w`` is the view depth in metres."""
    focal = 1.0 / np.tan(camera.fov / 2.0)
    aspect = window.frame_width / window.frame_height
    out = np.zeros((4, 4))
    out[0, 0] = focal / aspect
    out[1, 1] = -focal
    out[2, 2] = (far + near) / (near - far)
    out[2, 3] = 2.0 * far * near / (near - far)
    out[3, 2] = -1.0
    return out


def crop(window: Window) -> Matrix:
    """Return the ``(4, 4)`` matrix from the clip space of the frame to that of the window."""
    scale_x = window.frame_width / window.width
    scale_y = window.frame_height / window.height
    centre_x = 2.0 * (window.x + window.width / 2.0) / window.frame_width - 1.0
    centre_y = 2.0 * (window.y + window.height / 2.0) / window.frame_height - 1.0
    out = np.diag([scale_x, scale_y, 1.0, 1.0])
    out[0, 3] = -centre_x * scale_x
    out[1, 3] = -centre_y * scale_y
    return out


def window_projection(camera: Camera, window: Window, near: float, far: float) -> Matrix:
    """Return the off-centre perspective ``(4, 4)`` of the window."""
    return crop(window) @ full_projection(camera, window, near, far)


def ray_basis(view: Matrix, projection: Matrix) -> Matrix:
    """Return ``basis (3, 3)``; ``basis @ (x, y, 1)`` is the ray through the point ``x, y`` in [-1, 1]^2.

    Rays are in world space and of unit view depth: world position = eye + view depth * ray.
    """
    # ndc = P[:2, :2] * view.xy / depth - P[:2, 2], with view.z = -depth.
    inverse = np.eye(3)
    inverse[0, 0] = 1.0 / projection[0, 0]
    inverse[1, 1] = 1.0 / projection[1, 1]
    inverse[0, 2] = projection[0, 2] / projection[0, 0]
    inverse[1, 2] = projection[1, 2] / projection[1, 1]
    inverse[2, 2] = -1.0
    return np.linalg.inv(view[:3, :3]) @ inverse


def sky_homography(view: Matrix, projection: Matrix, previous_view: Matrix, previous_projection: Matrix) -> Matrix:
    """Return ``(3, 3)`` from the current ``(x, y, 1)`` of a direction to its previous homogeneous ``(x, y, w)``.

    ``x, y`` are in [-1, 1]^2.
    """
    rays = ray_basis(view, projection)
    return previous_projection[[0, 1, 3], :3] @ previous_view[:3, :3] @ rays


def jitter_offset(jitter: tuple[float, float], width: int, height: int) -> tuple[float, float]:
    """Return the clip-space offset of the SAMPLE: jitter in pixels right and down. The image moves the opposite way."""
    return 2.0 * jitter[0] / width, 2.0 * jitter[1] / height


def eye_position(view: Matrix) -> Matrix:
    """Return the world position ``(3,)`` of a camera."""
    return np.asarray(np.linalg.inv(view)[:3, 3], np.float64)
