import pandas as pd
from made_runs import made_run

from supersampling.reporting.figures.spread import spread_figure
from supersampling.reporting.methods import Method

RUNS = [made_run("a"), made_run("b", model="tus")]
METHODS = [Method(run.name, [run], leading=True) for run in RUNS]
CLIPS = pd.DataFrame({"scene": ["bar", "bar"], "clip": [0, 1], "psnr": [30.0, 31.0]})


def test_draws_the_methods_that_have_scores(tmp_path):
    path = tmp_path / "spread.pdf"
    assert spread_figure(METHODS, {"a": CLIPS}, path) == 1
    assert path.read_bytes().startswith(b"%PDF")


def test_without_scores_there_is_no_file(tmp_path):
    path = tmp_path / "spread.pdf"
    assert spread_figure(METHODS, {}, path) == 0
    assert not path.exists()
