import pytest
from mlflow.tracking import MlflowClient

from supersampling.runs import experiment as tracking


def test_a_store_whose_making_is_cut_short_leaves_nothing_that_the_next_start_trips_over(tmp_path, monkeypatch):
    path = tmp_path / "mlflow.db"

    def cut_short(client):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(MlflowClient, "search_experiments", cut_short)
        with pytest.raises(KeyboardInterrupt):
            tracking.open_experiment(f"sqlite:///{path}", "test", tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert tracking.open_experiment(f"sqlite:///{path}", "test", tmp_path).find("none") is None


def test_a_store_that_is_there_stays(tmp_path):
    uri = f"sqlite:///{tmp_path}/mlflow.db"
    first = tracking.open_experiment(uri, "test", tmp_path)
    run = first.start("one", {"ss.identity": "a"}, None)
    found = tracking.open_experiment(uri, "test", tmp_path).find("a")
    assert found is not None
    assert found.info.run_id == run
    assert [p.name for p in tmp_path.iterdir()] == ["mlflow.db"]
