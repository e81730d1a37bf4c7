"""The whole path: runs logged to a temporary MLflow store, as the trainer logs them, to a PDF and tables."""

import datetime
import re
from pathlib import Path

import pandas as pd
import pytest
from pypdf import PdfReader
from stored_runs import FINGERPRINT, ROOT, Log, config, mean_of, ours

from supersampling.commands.report import report


def test_a_cell_is_the_mean_over_clips_and_seeds(reports: Path, log: Log) -> None:
    table = ours(reports, 2)
    seeds = tuple(f"dlctus l1 seed={seed} x4" for seed in range(3))
    cell = table.loc["4×4/1", "DLCTUS", "PSNR"]
    assert cell.ours == pytest.approx(mean_of(log, "psnr", seeds), abs=1e-9)
    assert cell.seeds == 3
    assert cell.clips == 12
    assert cell.published == 35.49
    assert table.loc["4×4/1", "DLCTUS", "SSIM"].ours == pytest.approx(mean_of(log, "ssim_zero_pad11", seeds), abs=1e-9)


def test_what_was_not_run_or_lacks_is_said(reports: Path) -> None:
    assert ours(reports, 2).loc["4×4/1", "Xiao et al.", "PSNR"].state == "not run"
    assert "not measured" in set(ours(reports, 9).state)
    assert set(ours(reports, 7).loc["1"].state) == {"not run"}
    assert ours(reports, 2).loc["2×2/2", "DLCTUS", "PSNR"].state == "not run"
    assert ours(reports, 14).loc["4×4/1", "dilated motion vectors", "PSNR"].state == "not run"


def test_another_data_set_fills_only_its_own_row_and_is_named(reports: Path) -> None:
    cell = ours(reports, 2).loc["2×2/1", "JAU", "PSNR"]
    assert 42 < cell.ours < 46
    assert "77aa00bb" in cell.setting
    assert "77aa00bb" in (reports / "dlctus_table2.md").read_text()


def test_losses_are_found_by_theta_at_the_scale_that_was_run(reports: Path, log: Log) -> None:
    table = ours(reports, 10)
    percent = table.loc["θ = 0.5", "SSIM × 100", "SSIM × 100"]
    assert percent.ours == pytest.approx(100 * mean_of(log, "ssim_zero_pad11", ("dlctus theta=0.5 seed=0 x4",)))
    assert percent.published == 93.58
    assert table.loc["θ = 0.9", "PSNR (dB)", "PSNR"].state == "not run"
    assert "4×4, matched, data=laptop (3fa9c077), budget=laptop" in table.iloc[0].setting


def test_the_lead_of_the_best_is_paired_over_clips(reports: Path, log: Log) -> None:
    seeds = tuple(f"dlctus l1 seed={seed} x4" for seed in range(3))
    lead = mean_of(log, "psnr", seeds) - mean_of(log, "psnr", ("dlctus accumulate=none l1 seed=0 x4",))
    text = (reports / "dlctus_table16.md").read_text()
    match = re.search(r"paired over clips: 4×4/1 ([\d.]+) \(([\d.]+) to ([\d.]+)\)", text)
    assert match is not None
    mean, low, high = map(float, match.groups())
    assert mean == pytest.approx(lead, abs=0.006)
    # Unpaired, the clips' spread of 2.5 dB would make this half-width about 1 dB.
    assert 0 < high - low < 0.3


def test_the_pdf_holds_the_report(reports: Path) -> None:
    reader = PdfReader(reports / "dlctus.pdf")
    text = " ".join(page.extract_text() for page in reader.pages)
    text = re.sub(r"\s+", " ", text)
    for expected in (
        FINGERPRINT,
        "Xiao et al.",
        "not run",
        "35.49",
        "unresolved",
        "dlctus l1 seed=2 x4",
        "Linux x86_64",
    ):
        assert expected in text
    assert "99.0" not in text
    assert len(reader.pages) <= 16


def test_the_same_runs_give_the_same_bytes(reports: Path, log: Log, tmp_path: Path) -> None:
    report(config(log, tmp_path))
    names = sorted(path.name for path in reports.iterdir())
    assert names == sorted(path.name for path in tmp_path.iterdir())
    assert not [name for name in names if name.startswith(".")]
    same_day = (
        datetime.datetime.now(datetime.UTC).date().isoformat()
        in PdfReader(reports / "dlctus.pdf").pages[0].extract_text()
    )
    for name in names:
        if same_day or name != "dlctus.pdf":
            assert (reports / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_a_claim_is_judged_on_paired_clips(reports: Path, log: Log) -> None:
    claims = pd.read_csv(reports / "dlctus_claims.csv").set_index("claim")
    row = claims[claims.statement.str.contains("ahead of jitter-aligned")].iloc[0]
    lead = mean_of(log, "psnr", ("tus_thesis x4",)) - mean_of(log, "psnr", ("jau x4",))
    assert row.verdict == "reproduced"
    assert row.ours == pytest.approx(lead)
    assert row.low_95 < lead < row.high_95
    assert row.holds_on == "atrium foundry stk/zengarden"
    assert "not run" in set(claims.verdict)


def test_all_papers_and_an_overview(log: Log, reports: Path, tmp_path: Path) -> None:
    papers = sorted(path.stem for path in (ROOT / "reports" / "published").glob("*.yaml"))
    written = report(config(log, tmp_path, paper=None))
    assert [path.name for path in written] == [*(f"{name}.pdf" for name in papers), "overview.pdf"]
    alone, among_all = (folder / "dlctus_overview.csv" for folder in (reports, tmp_path))
    assert alone.read_text() == among_all.read_text()
    text = " ".join(page.extract_text() for page in PdfReader(tmp_path / "overview.pdf").pages)
    assert "All methods and all claims" in text
    assert FINGERPRINT in text
    claims = pd.read_csv(tmp_path / "overview_claims.csv").claim
    assert {name.split("-")[0] for name in claims} <= set(papers)
    assert {"overview_front.pdf", "overview_frames.pdf", "overview_training.pdf", "overview_dataset.csv"} <= {
        path.name for path in tmp_path.iterdir()
    }
