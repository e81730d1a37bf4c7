"""What an entry point prints and how it exits."""

import errno

import pytest
from omegaconf import OmegaConf

from supersampling.commands.entry import run
from supersampling.errors import UserError

NOTHING = OmegaConf.create()


def failing(error: BaseException, cause: BaseException | None = None):
    def task(cfg):
        raise error from cause

    return task


@pytest.mark.parametrize(
    ("error", "cause", "status", "sentence"),
    [
        (UserError("Bad value 3: use 2."), None, 2, "error: Bad value 3: use 2."),
        (RuntimeError("wrapped"), UserError("Bad value 4: use 2."), 2, "error: Bad value 4: use 2."),
        (OSError(errno.ENOSPC, "No space left on device"), None, 2, "error: The disk is full"),
        (KeyboardInterrupt(), None, 130, "continues from here"),
        (RuntimeError("half a file"), KeyboardInterrupt(), 130, "continues from here"),
        (SystemExit(1), None, 130, "continues from here"),  # Lightning's answer to an interrupt
    ],
)
def test_a_mistake_is_one_sentence(error, cause, status, sentence, capsys):
    with pytest.raises(SystemExit) as caught:
        run(failing(error, cause), NOTHING)
    said = capsys.readouterr().err
    assert caught.value.code == status
    assert sentence in said
    assert said.strip().count("\n") == 0


def test_our_own_mistakes_keep_their_stack_trace():
    with pytest.raises(ZeroDivisionError):
        run(lambda cfg: 1 / 0, NOTHING)
