"""Peak memory of a training step of each method as clips grow longer.

    python scripts/timing/memory.py                  all methods, laptop budget
    python scripts/timing/memory.py model=enss_m     selected methods; any overrides of train.py

Prints a Markdown table. Every point is a separate process: on a CPU its peak resident memory, including libraries and
data; on CUDA the maximum that PyTorch allocated.
"""

import multiprocessing
import os
import sys
from concurrent.futures import ProcessPoolExecutor

import torch
from case import Case, cases
from omegaconf import DictConfig

from supersampling.commands.entry import run
from supersampling.commands.resolvers import register
from supersampling.errors import UserError

FRAMES = (2, 4, 8, 16, 32)
# The second step starts with gradients and the optimizer's state in memory.
STEPS = 2


def peak(cfg: DictConfig, frames: int) -> float:
    """Return the peak memory in MB (10^6 bytes) of training steps on clips of ``frames`` frames, in a new process.

    As in the budget, frames at the start of a clip are not counted in the loss, but at least one frame is.
    """
    register()
    torch.set_num_threads(cfg.threads)
    uncounted = cfg.budget.frames - cfg.budget.counted
    cfg.budget.frames, cfg.budget.counted = frames, max(1, frames - uncounted)
    case = Case.from_config(cfg)
    for _ in range(STEPS):
        case.step()
    if case.device.type == "cuda":
        return torch.cuda.max_memory_allocated(case.device) / 1e6
    return _peak_resident_bytes() / 1e6


def _peak_resident_bytes() -> int:
    try:
        import resource
    except ImportError as error:
        raise UserError("Cannot measure the peak memory of a process: use Linux, macOS or a CUDA device.") from error
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return largest if sys.platform == "darwin" else largest * 1024


def measure(configs: dict[str, DictConfig]) -> None:
    # Each point is forked from a server that has imported the libraries and computed nothing.
    context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
    context.set_forkserver_preload(["lightning", "hydra.utils", "supersampling.training.fit"])
    cfg = next(iter(configs.values()))
    budget = cfg.budget
    print(
        f"MB; batches of {budget.batch}, crops of {budget.crop} pixels, {cfg.task.scale}x{cfg.task.scale}, "
        f"{cfg.threads} threads, PyTorch {torch.__version__}\n"
    )
    print(f"| model | {' | '.join(f'{n} frames' for n in FRAMES)} | per frame | per frame and clip |")
    print(f"|{' --- |' * (len(FRAMES) + 3)}")
    with ProcessPoolExecutor(1, mp_context=context, max_tasks_per_child=1) as pool:
        for name, config in configs.items():
            points = [pool.submit(peak, config, n).result() for n in FRAMES]
            slope = (points[-1] - points[-2]) / (FRAMES[-1] - FRAMES[-2])
            cells = [name, *(f"{p:.0f}" for p in points), f"{slope:.1f}", f"{slope / budget.batch:.2f}"]
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    selected = cases(sys.argv[1:])
    run(lambda _: measure(selected), selected)  # type: ignore[arg-type]
