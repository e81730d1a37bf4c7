"""The runs of a paper's pictures: for each of the compared labels those whose pictures are drawn."""

from dataclasses import dataclass

from supersampling.reporting.papers.schema import Picture
from supersampling.reporting.selection import choose_runs, joined, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.store import Run


@dataclass(frozen=True)
class PictureRuns:
    """A picture's runs by label; an empty list if nothing was run."""

    picture: Picture
    runs: dict[str, list[Run]]

    @property
    def missing(self) -> list[str]:
        return [label for label, runs in self.runs.items() if not runs]

    @property
    def present(self) -> dict[str, list[Run]]:
        return {label: runs for label, runs in self.runs.items() if runs}

    @property
    def setting(self) -> Setting:
        """The setting of the runs that are there: of a pool of several data sets only those that they are from."""
        return joined(sorted({Setting.of(run) for runs in self.runs.values() for run in runs}))


def choose_picture(picture: Picture, choice: Choice) -> PictureRuns:
    """Return the runs of one setting that agree in all that the picture does not name.

    Of several settings the first that has most labels.
    """
    selections = picture.selections
    best = PictureRuns(picture, {label: [] for label in selections})
    for _, pool in pools_for(choice, selections.values(), {}):
        cells = choose_runs(pool, selections).cells
        candidate = PictureRuns(picture, {label: cells[label] for label in selections})
        if len(candidate.missing) < len(best.missing):
            best = candidate
        if not best.missing:
            break
    return best
