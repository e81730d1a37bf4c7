"""``scene=gltf path=FILE`` renders data sets that depend on the file's content and not on its place."""

from pathlib import Path

import numpy as np
import pytest
from gltf_files import Builder
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import InstantiationException
from hydra.utils import instantiate

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.module import DataSource

ROOT = Path(__file__).resolve().parents[2]
SMALL = ["data=smoke", "data.workers=2", "data.train.clips=1", "data.train.frames=4"]


def source(root: Path, path: Path | None) -> DataSource:
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        cfg = compose("render", ["scene=gltf", f"path={path or 'null'}", f"paths.root={root}", *SMALL])
    return instantiate(cfg.data)


def model(path: Path, shade: int = 128) -> Path:
    """A textured square whose buffer lies beside the file."""
    path.parent.mkdir(exist_ok=True)
    file = Builder()
    pixels = np.random.default_rng(shade).integers(0, 256, (32, 32, 3), dtype=np.uint8)
    paint = file.material(pbrMetallicRoughness={"baseColorTexture": {"index": file.texture(pixels)}})
    file.node(mesh=file.square(paint))
    return file.gltf(path, "data.bin")


def test_a_file_becomes_data_whose_name_is_its_content_s(tmp_path):
    names = frozenset({"color", "target"})
    first = source(tmp_path, model(tmp_path / "a" / "board.gltf")).files(["train"], names)["train"][0]
    store = DatasetFile(first)
    assert store.spec.scene == "gltf/board"
    assert str(tmp_path) not in store.spec.to_json()
    assert store.read("target", 0, slice(1, None)).std() > 0.02
    elsewhere = source(tmp_path, model(tmp_path / "b" / "board.gltf"))
    other = source(tmp_path, model(tmp_path / "c" / "board.gltf", shade=7))
    assert [spec.file_name for spec in elsewhere.specs("train")] == [first.name]
    assert [spec.file_name for spec in other.specs("train")] != [first.name]


def test_without_a_file_it_says_what_is_missing(tmp_path):
    with pytest.raises(InstantiationException, match="path=FILE"):
        source(tmp_path, None)
    with pytest.raises(InstantiationException, match="nothing.glb"):
        source(tmp_path, tmp_path / "nothing.glb")
