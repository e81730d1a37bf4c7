"""The parts of a frame that claims name are parts of the real methods, and the backends are options."""

from pathlib import Path

import pytest
from made_up_benchmarks import FORMS, RENDERED, parts_of

from supersampling.reporting.papers.published import load_papers
from supersampling.runs.measurements import NO_METHOD, TOTAL, WHOLE

ROOT = Path(__file__).resolve().parents[2]
CLAIMS = [c for p in load_papers(ROOT / "reports" / "published", None) for c in p.claims if "benchmark:" in c.metric]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_parts_and_backends_exist(claim):
    for selection in claim.selections.values():
        backend, model = selection.get("backend", "eager"), selection["model"]
        assert (ROOT / "conf" / "backends" / f"{backend}.yaml").is_file()
        known = {TOTAL, WHOLE, *RENDERED}
        if model != NO_METHOD and "part" in selection:
            known |= set(parts_of(model, backend if backend in FORMS else "", 3))
        assert set(selection.get("part", WHOLE).split(" + ")) <= known
