"""Peak memory of a training step of each method as clips grow longer.

    python scripts/timing/memory.py                  all methods, laptop budget
    python scripts/timing/memory.py model=enss_m     some; any overrides of train.py

Prints a Markdown table. Every point is a process of its own: on a processor its peak resident memory, with libraries and data; on
CUDA what PyTorch had allocated at most.
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
STEPS = 2  # the second has gradients and the optimizer's memory from the start


def peak(cfg: DictConfig, frames: int) -> float:
    """MB (10^6 bytes) at most, in a process that does nothing else, of steps on clips of so many frames.

    As many frames at the start of a clip as in the budget's do not count in the loss, but one always does.
    """
    register()
    torch.set_num_threads(cfg.threads)
    unseen = cfg.budget.frames - cfg.budget.counted
    cfg.budget.frames, cfg.budget.counted = frames, max(1, frames - unseen)
    case = Case.of(cfg)
    for _ in range(STEPS):
        case.step()
    if case.device.type == "cuda":
        return torch.cuda.max_memory_allocated(case.device) / 1e6
    return _resident() / 1e6


def _resident() -> int:
    """Bytes that this process had in memory at most."""
    try:
        import resource
    except ImportError as error:
        raise UserError("Peak memory of a process needs Linux or macOS: use a CUDA device, or one of these.") from error
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024


def measure(configs: dict[str, DictConfig]) -> None:
    # A server that has imported the libraries and computed nothing: each point is forked from it, clean.
    context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
    context.set_forkserver_preload(["lightning", "hydra.utils", "supersampling.training.fit"])
    cfg = next(iter(configs.values()))
    budget = cfg.budget
    print(
        f"MB; batches of {budget.batch}, crops of {budget.crop} pixels, {cfg.task.scale}x{cfg.task.scale}, "
        f"{cfg.threads} threads, PyTorch {torch.__version__}\n"
    )
    print(f"| model | {' | '.join(f'{n} frames' for n in FRAMES)} | each more | of one clip |")
    print(f"|{' --- |' * (len(FRAMES) + 3)}")
    with ProcessPoolExecutor(1, mp_context=context, max_tasks_per_child=1) as pool:
        for name, config in configs.items():
            points = [pool.submit(peak, config, n).result() for n in FRAMES]
            each = (points[-1] - points[-2]) / (FRAMES[-1] - FRAMES[-2])
            cells = [name, *(f"{p:.0f}" for p in points), f"{each:.1f}", f"{each / budget.batch:.2f}"]
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    chosen = cases(sys.argv[1:])
    run(lambda _: measure(chosen), chosen)  # type: ignore[arg-type]
