"""A group of processes: all work together, and all end when one fails."""

import os
import signal
import time

import pytest
from torch.multiprocessing.spawn import ProcessExitedException

from supersampling.errors import UserError
from supersampling.training.processes import ProcessFailure, run_together


def fail_first(error, folder):
    """Raise an error in the second process; the first one waits, and then fails as a consequence."""
    rank = int(os.environ["LOCAL_RANK"])
    (folder / f"{rank}").write_text(str(os.getpid()))
    if rank == 1:
        while not (folder / "0").exists():
            time.sleep(0.01)
        if error is None:
            os.kill(os.getpid(), signal.SIGKILL)
        raise error
    time.sleep(60)


def write_share(folder):
    rank, size = os.environ["LOCAL_RANK"], os.environ["WORLD_SIZE"]
    (folder / rank).write_text(size)


@pytest.mark.parametrize(
    ("error", "kind", "message"),
    [
        (UserError("The disk is full."), UserError, "^The disk is full.$"),
        pytest.param(
            ValueError("odd"), ProcessFailure, "(?s)Process 1 of 0 to 1.*ValueError: odd", marks=pytest.mark.slow
        ),
        pytest.param(KeyboardInterrupt(), KeyboardInterrupt, "", marks=pytest.mark.slow),
        pytest.param(None, ProcessExitedException, "process 1 terminated with signal SIGKILL", marks=pytest.mark.slow),
    ],
    ids=["user's mistake", "error of ours", "interrupt", "killed"],
)
def test_the_first_failure_is_raised_and_all_end(tmp_path, error, kind, message):
    with pytest.raises(kind, match=message):
        run_together(fail_first, [error, tmp_path], 2)
    for rank in (0, 1):
        with pytest.raises(ProcessLookupError):
            os.kill(int((tmp_path / str(rank)).read_text()), 0)


@pytest.mark.slow
def test_each_process_knows_its_rank_and_leaves_this_one_as_it_was(tmp_path):
    before = dict(os.environ)
    run_together(write_share, [tmp_path], 3)
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"0": "3", "1": "3", "2": "3"}
    assert dict(os.environ) == before
