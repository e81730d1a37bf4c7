"""One report while it is made: its material, the paper that it is about, and what several sections share."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from supersampling.reporting.methods import Method
from supersampling.reporting.pages.appendix import Cell, claim_cells, number_runs, paper_cells
from supersampling.reporting.pages.material import Material, PaperRuns
from supersampling.reporting.papers.claims import Judged
from supersampling.reporting.papers.schema import Paper
from supersampling.reporting.papers.tables import Filled, fill
from supersampling.runs.store import Run

OVERVIEW = "overview"
PICTURED_METHODS = 7


@dataclass(frozen=True)
class Report:
    """A report of one paper, or the overview, which is about no paper (``subject`` None).

    ``build`` is the folder of all reports; `folder` receives this one's files.
    """

    material: Material
    subject: PaperRuns | None
    build: Path

    @property
    def name(self) -> str:
        return OVERVIEW if self.subject is None else self.subject.paper.paper

    @property
    def folder(self) -> Path:
        return self.build / self.name / "made"

    @property
    def stem(self) -> Path:
        """The beginning of its files' paths."""
        return self.folder / self.name

    @cached_property
    def judged(self) -> list[tuple[Paper, list[Judged]]]:
        """The judged claims of each of its papers; a paper without claims is left out."""
        papers = [item.paper for item in (self.material.papers if self.subject is None else [self.subject])]
        return [(paper, claims) for paper in papers if (claims := self.material.judged[paper.paper])]

    @cached_property
    def filled(self) -> list[Filled]:
        """The paper's tables with our numbers; empty for the overview."""
        if self.subject is None:
            return []
        return [fill(table, self.subject.paper, self.material.clips) for table in self.subject.tables]

    @cached_property
    def cells(self) -> list[Cell]:
        """Everything that runs fill, with these runs, for the appendix."""
        claims = [item for _, judged in self.judged for item in judged]
        if self.subject is not None:
            return paper_cells(self.material.methods, self.filled, claims, self.subject)
        methods = [(f"All methods · {method.label}", method.runs) for method in self.material.methods]
        return methods + claim_cells(claims)

    @property
    def runs(self) -> list[Run]:
        """The runs behind its cells."""
        return [run for _, runs in self.cells for run in runs]

    @cached_property
    def keys(self) -> Mapping[str, str]:
        """The runs' numbers in the appendix, by run id."""
        return number_runs(self.cells)

    @cached_property
    def pictured(self) -> list[Method]:
        """The leading methods, as many as fit a page's width: those of the paper's models first, then the better
        ones."""
        models = {run.model for run in self.subject.runs} if self.subject is not None else set()

        def rank(method: Method) -> tuple[bool, float]:
            psnr = method.average("test/psnr")
            return method.runs[0].model not in models, -math.inf if math.isnan(psnr) else -psnr

        leading = self.material.leading
        labels = {method.label for method in sorted(leading, key=rank)[:PICTURED_METHODS]}
        return [method for method in leading if method.label in labels]
