"""Pictures of what methods carry from frame to frame, such as DLCTUS's accumulation buffer (its thesis's table 17)."""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from supersampling.reporting.figures.pictures import folders_by_label
from supersampling.reporting.methods import Method
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, GalleryRow, Picture, Section
from supersampling.reporting.pages.sheet import Text

FULL_WIDTH = 7  # pictures
CAPTION = ", after a clip’s last frame, below the target’s crop. White is 1, black 0; of weights white is the largest."


def section(report: Report) -> Section | None:
    """Return the states of the pictured methods; None without any."""
    material = report.material
    galleries = state_galleries(report.pictured, material.pictures("state"), material.pictures("crops"), report.folder)
    return Section(title="States", galleries=galleries) if galleries else None


def state_galleries(
    methods: Sequence[Method], states: Mapping[str, Path], crops: Mapping[str, Path], out: Path
) -> list[Gallery]:
    """Copy each method's pictures beside the targets' crops to ``out``; one gallery per method.

    ``states`` and ``crops`` are the downloaded folders by run id. Columns are scenes, the target's crop above the
    state's pictures, a line for each kind; a scene without one of them is left out.
    """
    targets = {
        path.stem.removesuffix("_target"): path
        for folder in folders_by_label(methods, crops).values()
        for path in sorted(folder.glob("*_target.png"), reverse=True)
    }
    stems = sorted(targets, key=lambda stem: (int(stem.split("_")[0]), stem))
    galleries: list[Gallery] = []
    for label, folder in folders_by_label(methods, states).items():
        names = sorted({path.stem.removeprefix(f"{stem}_") for stem in stems for path in folder.glob(f"{stem}_*.png")})
        present = [stem for stem in stems if all((folder / f"{stem}_{name}.png").is_file() for name in names)]
        if not names or not present:
            continue
        lines: list[list[Picture | Text]] = [[Text(stem.partition("_")[2]) for stem in present]]
        for name, source in [("target", targets), *((name, None) for name in names)]:
            line: list[Picture | Text] = []
            for stem in present:
                image = f"state_{len(galleries)}_{name}_{stem}.png"
                shutil.copyfile(source[stem] if source else folder / f"{stem}_{name}.png", out / image)
                line.append(Picture(image))
            lines.append(line)
        order = " (from top to bottom)" if len(names) > 1 else ""
        title = f"{label}: {', '.join(names).replace('_', ' ')}"
        share = min(1.0, len(present) / FULL_WIDTH)
        galleries.append(Gallery([], [GalleryRow("", lines)], [Text(title, "bold"), Text(order + CAPTION)], share))
    return galleries
