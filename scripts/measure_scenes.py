"""Measurement of built-in scenes for their manifests.

python scripts/measure_scenes.py                  every built-in scene
python scripts/measure_scenes.py atrium bar       only these
python scripts/measure_scenes.py --costs atrium   seconds and bytes of each buffer, as a table; writes no manifest
"""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from supersampling import scenes
from supersampling.errors import UserError
from supersampling.render.measure.costs import costs, table
from supersampling.render.measure.scene import measure
from supersampling.scenes.built_in import BUILT_IN
from supersampling.scenes.load import load_scene
from supersampling.scenes.manifest import MEASURES, contradictions, parse, with_measured


def update(name: str) -> None:
    """Measure a scene, write its manifest, and print its numbers and the statements that they contradict."""
    path = Path(scenes.__file__).with_name(f"{name}.yaml")
    if not path.exists():
        raise UserError(f"Scene {name} has no {path.name} beside its code: write one first.")
    parse(path.read_text(encoding="utf-8"), name)
    began = time.perf_counter()
    measured = measure(load_scene(name))
    path.write_text(with_measured(path.read_text(encoding="utf-8"), measured), encoding="utf-8")
    manifest = parse(path.read_text(encoding="utf-8"), name)
    print(f"{name}, measured in {time.perf_counter() - began:.0f} s")
    for key, meaning in MEASURES.items():
        value = manifest.measured[key]
        print(f"  {key:28} {'-' if value is None else format(value, '<10g')} {meaning}")
    for sentence in contradictions(manifest):
        print(f"  ! {sentence}")


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Measure built-in scenes.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="built-in scenes, all of them by default")
    parser.add_argument("--costs", action="store_true", help="time and size of each buffer instead")
    options = parser.parse_args(arguments)
    try:
        for name in options.scenes or list(BUILT_IN):
            if options.costs:
                print(f"{name}\n\n{table(costs(load_scene(name)))}\n")
            else:
                update(name)
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
