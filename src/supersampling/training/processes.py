"""A group of processes, one for each device, which run the same function together.

The processes are new ones that get the function and its arguments, and nothing else. So neither a lock nor a store of
the process that starts them concerns them, it makes no difference how the command was started, and no state of the
group stays behind.
"""

import multiprocessing
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from multiprocessing.process import BaseProcess
from typing import Any

from lightning.fabric.plugins.environments.lightning import find_free_network_port
from torch.multiprocessing.spawn import ProcessException, ProcessExitedException, start_processes

from supersampling.errors import TimeLimitReached, UserError, find_time_limit, find_user_error, was_interrupted
from supersampling.process import prepare_process

GRACE = 5.0
"""Seconds in which the others may end by themselves when one has failed: a process that waits inside of a collective
operation sees no signal."""


class ProcessFailure(Exception):
    """An error in one of several processes; the message has its stack trace."""


def run_together(function: Callable[..., object], arguments: Sequence[Any], count: int) -> None:
    """Run ``function(*arguments)`` in ``count`` new processes and wait for them; when one fails, all end.

    ``LOCAL_RANK`` and the other variables that Lightning and ``torch.distributed`` read tell them apart.

    Raises:
        UserError: one of them raised it first.
        TimeLimitReached: they stopped at ``trainer.max_time``.
        KeyboardInterrupt: this process or one of them was interrupted.
        ProcessFailure: one of them raised another exception first.
        ProcessException: one of them was ended by a signal.
    """
    before = multiprocessing.active_children()
    failures = multiprocessing.get_context("spawn").SimpleQueue()
    try:
        group = start_processes(
            _run_member,
            (count, find_free_network_port(), failures, function, tuple(arguments)),
            nprocs=count,
            join=False,
            start_method="spawn",
        )
        while not group.join(grace_period=GRACE):
            pass
    except ProcessException as error:
        killed = isinstance(error, ProcessExitedException) and error.signal_name is not None
        if killed or failures.empty():
            raise
        raise failures.get() from None
    finally:
        _stop([process for process in multiprocessing.active_children() if process not in before])


def _run_member(
    rank: int, count: int, port: int, failures: Any, function: Callable[..., object], arguments: tuple[Any, ...]
) -> None:
    prepare_process()
    # A shell starts commands in the background with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    numbers = {"LOCAL_RANK": rank, "RANK": rank, "NODE_RANK": 0, "WORLD_SIZE": count, "MASTER_PORT": port}
    os.environ.update({name: str(value) for name, value in numbers.items()}, MASTER_ADDR="127.0.0.1")
    try:
        function(*arguments)
    except BaseException as error:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        # Before this process ends, so that the cause comes before what its end leads to in the others.
        failures.put(_portable(error, rank, count))
        sys.exit(1)


def _portable(error: BaseException, rank: int, count: int) -> BaseException:
    """Return an exception that can be sent to another process, and means the same there."""
    if was_interrupted(error):
        return KeyboardInterrupt()
    user_error = find_user_error(error)
    if user_error is not None:
        return UserError(str(user_error))
    time_limit = find_time_limit(error)
    if time_limit is not None:
        return TimeLimitReached(str(time_limit))
    trace = "".join(traceback.format_exception(error))
    return ProcessFailure(f"Process {rank} of 0 to {count - 1} failed.\n\n{trace}")


def _stop(processes: Sequence[BaseProcess]) -> None:
    """End processes: by an interrupt, or by force if they are not gone after `GRACE` seconds."""
    for process in processes:
        if process.pid is not None and process.is_alive():
            os.kill(process.pid, signal.SIGINT)
    end = time.monotonic() + GRACE
    for process in processes:
        process.join(max(0.0, end - time.monotonic()))
        if process.is_alive():
            process.kill()
            process.join()
