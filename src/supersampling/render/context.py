"""OpenGL context without a screen, and the diagnosis of why none opens."""

import ctypes
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import moderngl

from supersampling.errors import UserError

# Shared library: the Debian package that holds it. The loaders come before Mesa's part of EGL, in the order of use.
_PACKAGES = {"libEGL.so.1": "libegl1", "libGL.so.1": "libgl1", "libEGL_mesa.so.0": "libegl-mesa0"}
# Full names of the libraries: without them glcontext asks ldconfig, and without ldconfig it wants the compiler's
# libGL.so. The stub types each setting as a dictionary of settings, hence Any.
_BACKEND: Any = {"backend": "egl", "libegl": "libEGL.so.1", "libgl": "libGL.so.1"}
# Mesa's software rasteriser is a plug-in outside the library path.
_RASTERISER, _RASTERISER_PACKAGE = "swrast_dri.so", "libgl1-mesa-dri"
_DRIVER_FOLDERS = ("/usr/lib/*/dri", "/usr/lib/dri", "/usr/lib64/dri")
_MESA_ONLY = "__EGL_VENDOR_LIBRARY_FILENAMES=/usr/share/glvnd/egl_vendor.d/50_mesa.json"
# Prefixes of the variables by which the EGL loader, Mesa and glcontext choose a library or a driver.
_VARIABLES = ("__EGL", "EGL_", "GALLIUM_", "GLCONTEXT_", "LIBGL_", "MESA_")


def open_context() -> moderngl.Context:
    """Open an OpenGL 4.3 context without a screen.

    Raises:
        UserError: no context opens; the sentence names the missing packages, or what else to look at.
    """
    try:
        return moderngl.create_context(standalone=True, require=430, **_BACKEND)
    except Exception as error:  # moderngl raises bare Exceptions, and OSError for a missing library
        reason = str(error).strip().rstrip(".") or type(error).__name__
        raise UserError(f"No OpenGL 4.3 context opens without a screen ({reason}): {_remedy()}") from None


def loadable(library: str) -> bool:
    """Return True if the dynamic linker finds ``library`` and all that it depends on."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def missing_libraries(can_load: Callable[[str], bool] = loadable) -> dict[str, str]:
    """Return the libraries for software rendering that cannot be loaded, each with its Debian package."""
    missing = {library: package for library, package in _PACKAGES.items() if not can_load(library)}
    drivers = [str(path) for folder in _DRIVER_FOLDERS for path in Path("/").glob(f"{folder[1:]}/{_RASTERISER}")]
    if not any(can_load(driver) for driver in drivers):
        missing[_RASTERISER] = _RASTERISER_PACKAGE
    return missing


def _remedy() -> str:
    """Return the second half of the message: what is missing, or which choice of a driver to undo."""
    missing = missing_libraries()
    if missing:
        libraries, packages = ", ".join(missing), " ".join(missing.values())
        return f"{libraries} cannot be loaded; run `apt-get install {packages}`."
    settings = [f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith(_VARIABLES)]
    if settings:
        return f"all its libraries can be loaded; unset what chooses another driver: {' '.join(settings)}."
    return f"all its libraries can be loaded, so the graphics driver fails; set {_MESA_ONLY} to render in software."
