"""A context that does not open is explained by what is missing on this machine."""

import os

import moderngl
import pytest

from supersampling.errors import UserError
from supersampling.render import context
from supersampling.render.context import loadable, missing_libraries, open_context


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch) -> None:
    """No context opens, and no variable of this machine chooses a driver."""

    def fail(*_: object, **__: object) -> None:
        raise OSError("libEGL.so.1 not loaded")

    monkeypatch.setattr(moderngl, "create_context", fail)
    for name in [name for name in os.environ if name.startswith(context._VARIABLES)]:
        monkeypatch.delenv(name)


def test_loadable() -> None:
    assert loadable("libc.so.6")
    assert not loadable("libnothing.so.1")


@pytest.mark.parametrize(
    ("library", "package"),
    [
        ("libEGL.so.1", "libegl1"),
        ("libGL.so.1", "libgl1"),
        ("libEGL_mesa.so.0", "libegl-mesa0"),
        ("swrast_dri.so", "libgl1-mesa-dri"),
    ],
)
def test_names_only_the_missing_library(library: str, package: str) -> None:
    assert missing_libraries(lambda name: not name.endswith(library)) == {library: package}


def test_bare_machine() -> None:
    assert list(missing_libraries(lambda _: False).values()) == ["libegl1", "libgl1", "libegl-mesa0", "libgl1-mesa-dri"]


def test_message_names_missing_packages(broken: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "missing_libraries", lambda: {"libGL.so.1": "libgl1"})
    with pytest.raises(UserError, match=r"libGL\.so\.1 cannot be loaded; run `apt-get install libgl1`\.$"):
        open_context()


def test_message_names_variables_if_nothing_is_missing(broken: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "missing_libraries", dict)
    with pytest.raises(UserError, match="set __EGL_VENDOR_LIBRARY_FILENAMES=.*50_mesa.json to render in software") as e:
        open_context()
    assert "apt-get" not in str(e.value)
    monkeypatch.setenv("GALLIUM_DRIVER", "zink")
    with pytest.raises(UserError, match=r"unset what chooses another driver: GALLIUM_DRIVER=zink\.$"):
        open_context()


@pytest.mark.parametrize("reason", [Exception(""), OSError("libEGL.so.1"), ImportError("glcontext")])
def test_every_error_is_explained(reason: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise reason

    monkeypatch.setattr(moderngl, "create_context", fail)
    with pytest.raises(UserError, match="No OpenGL 4.3 context opens without a screen") as e:
        open_context()
    assert (str(reason) or "(Exception)") in str(e.value)
