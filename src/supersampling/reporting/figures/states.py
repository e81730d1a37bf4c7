"""Pictures of what methods carry from frame to frame, such as DLCTUS's accumulation buffer (its thesis's table 17)."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from supersampling.reporting.figures.pictures import folder_of
from supersampling.reporting.pages.overview import Method


@dataclass(frozen=True)
class StateTable:
    """One kind of picture of one method: a column a scene, the target's crop above the state's."""

    label: str
    name: str
    scenes: list[str]
    targets: list[str]
    images: list[str]


def state_tables(
    found: Sequence[Method], states: Mapping[str, Path], crops: Mapping[str, Path], out: Path
) -> list[StateTable]:
    """Copy each method's pictures beside the targets' crops to ``out``.

    ``states`` and ``crops`` are the downloaded folders by run id.
    """
    targets = {
        path.stem.removesuffix("_target"): path
        for folder in folder_of(found, crops).values()
        for path in sorted(folder.glob("*_target.png"), reverse=True)
    }
    tables: list[StateTable] = []
    for label, folder in folder_of(found, states).items():
        stems = sorted(targets, key=lambda stem: (int(stem.split("_")[0]), stem))
        names = {path.stem.removeprefix(f"{s}_") for s in stems for path in folder.glob(f"{s}_*.png")}
        for name in sorted(names):
            here = [stem for stem in stems if (folder / f"{stem}_{name}.png").is_file()]
            table = StateTable(
                label,
                name,
                [stem.partition("_")[2] for stem in here],
                [f"state_{stem}_target.png" for stem in here],
                [f"state_{len(tables)}_{stem}.png" for stem in here],
            )
            for stem, target, image in zip(here, table.targets, table.images):
                shutil.copyfile(targets[stem], out / target)
                shutil.copyfile(folder / f"{stem}_{name}.png", out / image)
            tables.append(table)
    return tables
