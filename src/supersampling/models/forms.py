"""Forms of a method that exist for deployment only."""

from typing import Protocol, runtime_checkable

from torch import Tensor

from supersampling.models.base import Upsampler


@runtime_checkable
class Precomputable(Protocol):
    """A method whose kernels can be computed in advance for a jitter sequence ``(N, 2)``."""

    def with_precomputed_kernels(self, jitters: Tensor) -> Upsampler: ...


@runtime_checkable
class Optimisable(Protocol):
    """A method that has a faster form of equal output."""

    def for_inference(self) -> Upsampler: ...


def precompute_kernels(model: Upsampler, jitters: Tensor | None) -> Upsampler:
    """Return a method with its kernels computed for ``jitters``; the same method if it has none or reads no jitter."""
    return (
        model.with_precomputed_kernels(jitters) if isinstance(model, Precomputable) and jitters is not None else model
    )


def optimise(model: Upsampler, jitters: Tensor | None) -> Upsampler:
    """Return the form of a method for inference: kernels computed in advance, then rewrites of equal output."""
    model = precompute_kernels(model, jitters)
    return model.for_inference() if isinstance(model, Optimisable) else model
