"""Pictures of the README: a contact sheet of the scenes, and crops of the newest finished runs of one data set.

python scripts/readme_pictures.py [scenes] [crops]

writes docs/images/scenes.jpg and docs/images/crops.png, both by default.
"""

import sys
from pathlib import Path

import mlflow
import numpy as np
from PIL import Image, ImageDraw

from supersampling.render.camera import Shot, Window
from supersampling.render.paths import camera_path
from supersampling.render.renderer import Renderer
from supersampling.runs.location import uri_of_file
from supersampling.scenes.load import load_scene

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
# Scene, route, seed.
STILLS = (
    ("airstrip", 5, 0),
    ("arena", 7, 0),
    ("atrium", 2, 0),
    ("bar", 8, 1),
    ("foundry", 0, 4),
    ("louvres", 7, 0),
    ("market", 0, 0),
    ("sundial", 0, 1),
    ("turntable", 6, 0),
    ("stk/black_forest", 1, 1),
    ("stk/ravenbridge_mansion", 0, 0),
    ("stk/zengarden", 0, 0),
)
COLUMNS = 4
METHODS = ("bicubic", "jau", "tus", "dlctus")


def still(name: str, route: int, seed: int) -> Image.Image:
    """Return a 400x225 picture from a scene's route, labelled with the scene's name."""
    scene = load_scene(name)
    path = camera_path(scene.routes[route], np.random.default_rng(seed), 8)
    window = Window(400, 225, 0, 0, 400, 225)
    shot = Shot(path.cameras[5], path.cameras[4], path.seconds[5], path.seconds[4], window)
    with Renderer(scene) as renderer:
        picture = Image.fromarray(np.round(255.0 * renderer.target(shot, 4, 0.0)).astype(np.uint8))
    draw = ImageDraw.Draw(picture)
    draw.text((8, 6), name, fill="white", stroke_width=2, stroke_fill="black", font_size=16)
    return picture


def contact_sheet() -> Image.Image:
    stills = [np.asarray(still(*arguments)) for arguments in STILLS]
    rows = [np.concatenate(stills[k : k + COLUMNS], axis=1) for k in range(0, len(stills), COLUMNS)]
    return Image.fromarray(np.concatenate(rows))


def crops() -> Image.Image:
    """Return one row per scene: input, each method's output and target, with names above."""
    mlflow.set_tracking_uri(uri_of_file(ROOT / "mlflow.db"))
    finished = "tags.`ss.kind` = 'job' and attributes.status = 'FINISHED'"
    runs = mlflow.search_runs(experiment_names=["supersampling"], filter_string=finished)
    runs = runs[runs["tags.ss.dataset"] == runs["tags.ss.dataset"].iloc[0]]
    folders = {}
    for method in METHODS:
        run_id = runs[runs["tags.ss.method"] == method].iloc[0]["run_id"]
        folders[method] = Path(mlflow.artifacts.download_artifacts(run_id=run_id, artifact_path="crops"))
    rows = []
    for target in sorted(folders["jau"].glob("*_target.png")):
        stem = target.name.removesuffix("_target.png")
        names = [folders["jau"] / f"{stem}_input.png", *(folders[m] / f"{stem}.png" for m in METHODS), target]
        cells = [np.asarray(Image.open(n).resize((192, 192), Image.Resampling.NEAREST)) for n in names]
        rows.append(np.concatenate(cells, axis=1))
    picture = Image.fromarray(np.concatenate(rows))
    headed = Image.new("RGB", (picture.width, picture.height + 22), "white")
    headed.paste(picture, (0, 22))
    draw = ImageDraw.Draw(headed)
    for k, name in enumerate(("input", *METHODS, "target")):
        draw.text((192 * k + 96, 11), name, fill="black", anchor="mm", font_size=16)
    return headed


def main() -> None:
    IMAGES.mkdir(parents=True, exist_ok=True)
    parts = sys.argv[1:] or ["scenes", "crops"]
    if "scenes" in parts:
        contact_sheet().save(IMAGES / "scenes.jpg", quality=85)
    if "crops" in parts:
        crops().save(IMAGES / "crops.png", optimize=True)


if __name__ == "__main__":
    main()
