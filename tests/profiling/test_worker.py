"""Worker processes: calls, errors that leave the parent process running, memory, ceilings and precisions."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.models import precision
from supersampling.profiling import ceiling, memory
from supersampling.profiling.worker import CaseError, Worker

CPU = torch.device("cpu")
SCORE = Path("/proc/self/oom_score_adj")


class Adder:
    def __init__(self, start):
        self.sum = start

    @staticmethod
    def preload(start):
        pass

    def add(self, n):
        self.sum += n
        return self.sum, torch.get_num_threads(), os.getpid()

    def fail(self):
        raise UserError("It fails.")

    def hog(self, size):
        return float(np.ones(size, dtype=np.uint8)[-1])

    def retained(self):
        """Return the bytes of a large buffer that the process retains after it is freed."""
        memory.retain_freed()
        before = memory.usage(CPU)
        big = np.ones(2**27, dtype=np.uint8)
        del big
        return memory.usage(CPU) - before

    def score(self):
        return int(SCORE.read_text())

    def vanish(self):
        os._exit(3)


class Broken:
    def __init__(self):
        raise ValueError("first line\nsecond line")


def test_worker_keeps_its_object():
    worker = Worker(1, None, Adder, 5)
    try:
        assert worker.call("add", 2)[:2] == (7, 1)
        total, _, process = worker.call("add", 3)
        assert total == 10
        assert process != os.getpid()
    finally:
        worker.close()


@pytest.mark.parametrize(
    ("name", "values", "reason", "for_memory"),
    [
        ("fail", (), r"^It fails\.$", False),
        ("hog", (2**30,), r"^It needs more memory than there is\.$", True),
        ("vanish", (), r"exit code 3", True),
    ],
)
def test_errors_are_one_sentence(name, values, reason, for_memory):
    worker = Worker(1, 2**28, Adder, 0)
    try:
        with pytest.raises(CaseError, match=reason) as caught:
            worker.call(name, *values)
        assert caught.value.memory == for_memory
    finally:
        worker.close()


@pytest.mark.skipif(not SCORE.is_file(), reason="the system has no such score")
def test_system_ends_the_worker_first_without_memory():
    worker = Worker(1, 2**28, Adder, 0)
    try:
        assert worker.call("score") == 1000
    finally:
        worker.close()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the allocator of another libc")
def test_process_can_retain_freed_memory():
    worker = Worker(1, None, Adder, 0)
    try:
        assert worker.call("retained") > 2**26
    finally:
        worker.close()


def test_object_that_cannot_be_created():
    with pytest.raises(CaseError, match=r"^ValueError: first line$"):
        Worker(1, None, Broken)


PEAK = """
import numpy as np, torch
from supersampling.profiling import memory
cpu = torch.device("cpu")
before = memory.usage(cpu)
big = np.ones(2**27, dtype=np.uint8)
assert memory.usage(cpu) - before > 2**26
del big
assert memory.peak(cpu) - before > 2**26
memory.reset_peak(cpu)
assert memory.peak(cpu) - before < 2**26
assert memory.available(cpu) > 2**26
"""


def test_peak_memory():
    """In a new process: one that has timed methods keeps the memory that it frees."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", PEAK], check=True, env=environment)


def test_ceilings_are_those_of_the_clock(monkeypatch):
    """A product of n x n matrices has n^3 multiply-accumulates; a copy reads and writes all bytes.

    The fastest run counts.
    """
    monkeypatch.setitem(ceiling.SIDE, "cpu", 20)
    monkeypatch.setitem(ceiling.COPIED, "cpu", 4000)
    lengths = (3.0, 2.0, 5.0), (4.0, 6.0, 1.0), (0.5, 0.25, 4.0)  # product, convolution, copy
    readings = iter([value for k, length in enumerate(sum(lengths, ())) for value in (10.0 * k, 10.0 * k + length)])
    monkeypatch.setattr(ceiling.time, "perf_counter", lambda: next(readings))
    result = ceiling.measure(CPU, torch.float32, 3)
    assert (result.macs, result.bytes) == (20**3 / 1.0, 8000 / 0.25)


def test_convolution_is_the_product(monkeypatch):
    """The results are equal, so the multiply-accumulates are, too."""
    monkeypatch.setitem(ceiling.SIDE, "cpu", 20)
    product, convolution = ceiling.Kernels(CPU, torch.float32).products
    transposed = convolution()[0, :, 0, :]  # b @ a
    assert transposed.shape == product().shape
    torch.manual_seed(0)
    a, b = torch.randn(20, 20), torch.randn(20, 20)
    assert torch.allclose(ceiling._product(a, b)(), a @ b, atol=1e-5)
    assert torch.allclose(ceiling._convolution(b, a)()[0, :, 0, :], a @ b, atol=1e-5)


@pytest.mark.parametrize(
    ("flags", "expected"),
    [("fpu avx512f avx512_bf16", {"bfloat16"}), ("fpu amx_fp16 amx_bf16", {"bfloat16", "float16"}), ("fpu", set())],
)
def test_precisions_of_a_processor(monkeypatch, tmp_path, flags, expected):
    info = tmp_path / "cpuinfo"
    info.write_text(f"processor : 0\nmodel name : bf16 is in the name\nflags\t\t: {flags}\n")
    monkeypatch.setattr(precision, "_CPUINFO", info)
    reasons = {p: precision.missing_arithmetic(CPU, p) for p in precision.TYPES}
    assert {p for p, reason in reasons.items() if not reason} == {"float32", *expected}
    assert all(reason.endswith(".") and p in reason for p, reason in reasons.items() if reason)
