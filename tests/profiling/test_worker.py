"""Processes that hold what is asked of them, and whose end is no end of the one who asks."""

import os
import platform
from pathlib import Path

import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.profiling import ceiling, memory, precision
from supersampling.profiling.worker import Failed, Worker

CPU = torch.device("cpu")
SCORE = Path("/proc/self/oom_score_adj")


class Adds:
    def __init__(self, start):
        self.sum = start

    @staticmethod
    def import_first(start):
        pass

    def add(self, n):
        self.sum += n
        return self.sum, torch.get_num_threads(), os.getpid()

    def fail(self):
        raise UserError("It is so.")

    def hog(self, size):
        return float(np.ones(size, dtype=np.uint8)[-1])

    def kept(self):
        """How much of a large buffer the process still holds once it is freed."""
        memory.keep()
        before = memory.held(CPU)
        big = np.ones(2**27, dtype=np.uint8)
        del big
        return memory.held(CPU) - before

    def score(self):
        return int(SCORE.read_text())

    def vanish(self):
        os._exit(3)


class Never:
    def __init__(self):
        raise ValueError("not this\nsecond line")


def test_it_keeps_what_it_holds():
    worker = Worker(1, None, Adds, 5)
    try:
        assert worker.ask("add", 2)[:2] == (7, 1)
        total, _, process = worker.ask("add", 3)
        assert total == 10
        assert process != os.getpid()
    finally:
        worker.close()


@pytest.mark.parametrize(
    ("name", "values", "reason", "for_memory"),
    [
        ("fail", (), r"^It is so\.$", False),
        ("hog", (2**30,), r"^It needs more memory than there is\.$", True),
        ("vanish", (), r"exit code 3", True),
    ],
)
def test_what_goes_wrong_is_a_sentence(name, values, reason, for_memory):
    worker = Worker(1, 2**28, Adds, 0)
    try:
        with pytest.raises(Failed, match=reason) as caught:
            worker.ask(name, *values)
        assert caught.value.memory == for_memory
    finally:
        worker.close()


@pytest.mark.skipif(not SCORE.is_file(), reason="the system keeps no such score")
def test_a_machine_out_of_memory_ends_the_worker_first():
    worker = Worker(1, 2**28, Adds, 0)
    try:
        assert worker.ask("score") == 1000
    finally:
        worker.close()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another libc's allocator")
def test_a_process_can_keep_what_it_frees():
    worker = Worker(1, None, Adds, 0)
    try:
        assert worker.ask("kept") > 2**26
    finally:
        worker.close()


def test_what_cannot_be_made():
    with pytest.raises(Failed, match=r"^ValueError: not this$"):
        Worker(1, None, Never)


def test_peak_memory():
    device = torch.device("cpu")
    held = memory.held(device)
    big = np.ones(2**27, dtype=np.uint8)
    assert memory.held(device) - held > 2**26
    del big
    assert memory.peak(device) - held > 2**26
    memory.forget_peak(device)
    assert memory.peak(device) - held < 2**26
    assert memory.available() > 2**26


def test_ceilings_are_the_clock_s(monkeypatch):
    """A product of n x n matrices has n^3 multiply-accumulates; a copy reads and writes each byte. The fastest run counts."""
    monkeypatch.setitem(ceiling.SIDE, "cpu", 20)
    monkeypatch.setitem(ceiling.COPIED, "cpu", 4000)
    lengths = (
        3.0,
        2.0,
        5.0,
        4.0,
        6.0,
        1.0,
        0.5,
        0.25,
        4.0,
    )  # three of the product, of the convolution, of the copy
    readings = iter([value for k, length in enumerate(lengths) for value in (10.0 * k, 10.0 * k + length)])
    monkeypatch.setattr(ceiling.time, "perf_counter", lambda: next(readings))
    found = ceiling.measure(torch.device("cpu"), torch.float32, 3)
    assert (found.macs, found.bytes) == (20**3 / 1.0, 8000 / 0.25)


def test_the_convolution_is_the_product(monkeypatch):
    """Both give the same numbers, so that both take the same multiply-accumulates."""
    monkeypatch.setitem(ceiling.SIDE, "cpu", 20)
    product, convolution = ceiling.Kernels(torch.device("cpu"), torch.float32).products
    transposed = convolution()[0, :, 0, :]  # b @ a
    assert transposed.shape == product().shape
    torch.manual_seed(0)
    a, b = torch.randn(20, 20), torch.randn(20, 20)
    assert torch.allclose(ceiling._product(a, b)(), a @ b, atol=1e-5)
    assert torch.allclose(ceiling._convolution(b, a)()[0, :, 0, :], a @ b, atol=1e-5)


@pytest.mark.parametrize(
    ("flags", "there"),
    [
        ("fpu avx512f avx512_bf16", {"bfloat16"}),
        ("fpu amx_fp16 amx_bf16", {"bfloat16", "float16"}),
        ("fpu", set()),
    ],
)
def test_a_processor_s_precisions(monkeypatch, tmp_path, flags, there):
    info = tmp_path / "cpuinfo"
    info.write_text(f"processor : 0\nmodel name : bf16 is in the name\nflags\t\t: {flags}\n")
    monkeypatch.setattr(precision, "_CPUINFO", info)
    lacking = {p: precision.lacking(torch.device("cpu"), p) for p in ("float32", "bfloat16", "float16", "int8")}
    assert {p for p, why in lacking.items() if not why} == {"float32", *there}
    assert all(why.endswith(".") and p in why for p, why in lacking.items() if why)
