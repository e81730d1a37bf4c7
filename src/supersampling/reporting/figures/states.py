"""Pictures of what methods carry from frame to frame, such as DLCTUS's accumulation buffer (its thesis's table 17)."""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from supersampling.reporting.figures.pictures import folders_by_label
from supersampling.reporting.methods import Method
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, GalleryRow, Picture, Section
from supersampling.reporting.pages.sheet import Text

CAPTION = ", after a clip’s last frame, below the target’s crop. White is 1, black 0."


def section(report: Report) -> Section | None:
    """Return the states of the pictured methods; None without any."""
    material = report.material
    galleries = state_galleries(report.pictured, material.pictures("state"), material.pictures("crops"), report.folder)
    return Section(title="States", galleries=galleries) if galleries else None


def state_galleries(
    methods: Sequence[Method], states: Mapping[str, Path], crops: Mapping[str, Path], out: Path
) -> list[Gallery]:
    """Copy each method's pictures beside the targets' crops to ``out``; one gallery per kind of picture and method.

    ``states`` and ``crops`` are the downloaded folders by run id. Columns are scenes, the target's crop above the
    state's.
    """
    targets = {
        path.stem.removesuffix("_target"): path
        for folder in folders_by_label(methods, crops).values()
        for path in sorted(folder.glob("*_target.png"), reverse=True)
    }
    stems = sorted(targets, key=lambda stem: (int(stem.split("_")[0]), stem))
    galleries: list[Gallery] = []
    for label, folder in folders_by_label(methods, states).items():
        names = {path.stem.removeprefix(f"{stem}_") for stem in stems for path in folder.glob(f"{stem}_*.png")}
        for name in sorted(names):
            present = [stem for stem in stems if (folder / f"{stem}_{name}.png").is_file()]
            lines: list[list[Picture | Text]] = [[Text(stem.partition("_")[2]) for stem in present], [], []]
            for stem in present:
                target, image = f"state_{stem}_target.png", f"state_{len(galleries)}_{stem}.png"
                shutil.copyfile(targets[stem], out / target)
                shutil.copyfile(folder / f"{stem}_{name}.png", out / image)
                lines[1].append(Picture(target))
                lines[2].append(Picture(image))
            galleries.append(Gallery([], [GalleryRow("", lines)], [Text(f"{label}: {name}", "bold"), Text(CAPTION)]))
    return galleries
