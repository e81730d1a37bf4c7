"""What a person gets wrong gets one clear sentence, a non-zero exit, no stack trace, and leaves nothing half-
written."""

import pytest
from answers import run_script

from supersampling.scenes.stk import find_data


@pytest.fixture
def run(command, tmp_path):
    """Return a function that runs a command in this process and returns its status and what it wrote to stderr."""

    def call(name: str, *overrides: str) -> tuple[int, str]:
        answer = command(name, f"paths.root={tmp_path}", *overrides)
        return answer.status, answer.err

    return call


@pytest.fixture
def own(make_file, tmp_path):
    """Overrides that name files of the test's own."""
    names = {split: make_file(tmp_path, split) for split in ("train", "val", "test")}
    return ["data=files", "metrics=fast", "scene=atrium", *(f"data.{s}=[{p}]" for s, p in names.items())]


CASES = {
    "unknown option": (["loss.thetta=0.1"], "thetta"),
    "unknown choice": (["model=dlcuts"], "dlcuts"),
    "value out of range": (["loss.theta=1.5"], "loss.theta=1.5"),
    "value of another type": (["budget.batch=many"], "budget.batch=many"),
    "scale out of range": (["task.scale=9"], "task.scale=9"),
    "scale of the model alone": (["model.scale=2"], "model.scale=2 differs from task.scale=4: set task.scale"),
    "data set of another scale": (["task.scale=2"], "scale 4, but task.scale=2"),
    "too small a window": (["budget.crop=512"], "budget.crop=512"),
    "unreachable server": (["tracking_uri=http://127.0.0.1:9"], "127.0.0.1:9"),
}


@pytest.mark.parametrize("case", CASES)
def test_train(case, own, tmp_path, run):
    overrides, part = CASES[case]
    before = set(tmp_path.rglob("*.h5*"))
    status, said = run("train", *own, "budget=smoke", "baselines=[]", *overrides)
    assert status != 0
    assert part in said
    assert set(tmp_path.rglob("*.h5*")) == before


@pytest.mark.parametrize(
    ("content", "part"),
    [(b"\x89HDF\r\n\x1a\n truncated", "is an HDF5 file that is truncated or damaged"), (None, "broken.h5 not found")],
)
def test_a_broken_file(content, part, own, tmp_path, run):
    path = tmp_path / "broken.h5"
    if content is not None:
        path.write_bytes(content)
    status, said = run("train", *own, f"data.train=[{path}]")
    assert (status, said.count("\n")) == (2, 1)
    assert part in said


@pytest.mark.parametrize(
    ("override", "part"),
    [
        ("scene=atrum", "Unknown scene atrum"),
        ("splits=[dev]", "dev"),
        ("task.jitter=hilbert", "hilbert"),
        ("data.test.window=[4,4]", "4"),
        ("data.camera=run", "run"),
        ("buffers=[colour]", "Unknown buffer colour"),
        ("scene=gltf", "path=FILE"),
        ("import=qrisp", "import_capture.py layout=qrisp"),
        ("export=nsrd", "export_capture.py layout=nsrd"),
    ],
)
def test_render(override, part, tmp_path, run):
    scene = [] if override.startswith("scene") else ["scene=atrium"]
    status, said = run("render", "data=smoke", *scene, override)
    assert (status, said.count("\n")) == (2, 1)
    assert part in said
    assert not list(tmp_path.rglob("*.h5"))


@pytest.mark.parametrize("name", ["no_such_track", "../../etc"])
def test_no_such_track(name, tmp_path, run, monkeypatch):
    """The sentence depends on the game's data: the fake data of one track, and whatever this machine has."""
    track = tmp_path / "game" / "tracks" / "lane"
    track.mkdir(parents=True)
    for file in ("scene.xml", "quads.xml"):
        (track / file).write_text("<scene/>")
    sentence = f"Unknown SuperTuxKart track {name}"
    monkeypatch.setenv("SUPERTUXKART_DATADIR", str(tmp_path / "game"))
    status, said = run("render", f"scene=stk/{name}")
    assert (status, said.count("\n")) == (2, 1)
    assert f"{sentence}: use one of lane." in said
    monkeypatch.setenv("SUPERTUXKART_DATADIR", "")
    status, said = run("render", f"scene=stk/{name}")
    assert (status, said.count("\n")) == (2, 1)
    assert ("SuperTuxKart's data are not installed" if find_data() is None else sentence) in said
    assert not list(tmp_path.rglob("*.h5"))


def test_no_game_data(tmp_path, run, monkeypatch):
    monkeypatch.setenv("SUPERTUXKART_DATADIR", str(tmp_path / "none"))
    status, said = run("render", "scene=stk/zengarden")
    assert status == 2
    assert "supertuxkart-data" in said


def test_no_opengl(tmp_path):
    """Every library is installed, and a variable hides the driver: the sentence names the variable, no package."""
    variable = "__EGL_VENDOR_LIBRARY_FILENAMES"
    root = f"paths.root={tmp_path}"
    answer = run_script("render", ["data=smoke", "scene=atrium", root], **{variable: "/nothing.json"})
    assert answer.status == 2
    assert f"{variable}=/nothing.json" in answer.err
    assert "apt-get" not in answer.err
    assert "Traceback" not in answer.err


def test_an_unwritable_folder(tmp_path, run):
    (tmp_path / "file").write_text("not a folder")
    status, said = run("render", "data=smoke", "scene=atrium", f"paths.data={tmp_path}/file/data")
    assert (status, said.count("\n")) == (2, 1)
    assert "paths.data" in said


def test_evaluate_without_weights(own, run):
    status, said = run("evaluate", *own)
    assert status == 2
    assert "checkpoint=FILE" in said
    status, said = run("evaluate", *own, "run=0123")
    assert status == 2
    assert "0123" in said


def test_report_without_runs(tmp_path, command):
    answer = command("report", f"tracking_uri=sqlite:///{tmp_path}/none.db", f"output={tmp_path}/out")
    assert (answer.status, answer.err.count("\n")) == (2, 1)
