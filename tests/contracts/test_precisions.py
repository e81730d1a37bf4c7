"""Every model and stage in the number formats of ``trainer.precision``: a forward and a backward pass of a training."""

import copy

import pytest
import torch
from model_cases import clip, every_variant, model_of

from supersampling.frames import Frame
from supersampling.training.module import unroll


@pytest.mark.parametrize("dtype", [torch.float64, torch.bfloat16], ids=str)
@every_variant
def test_a_step_in_one_number_format(variant, dtype):
    """As with ``64-true`` and ``bf16-true``: weights and buffers of a clip have the type, and so have gradients."""
    model = copy.deepcopy(model_of(*variant, dtype=torch.float32)).to(dtype)
    buffers = clip(model.requires | model.compares | {"target"}, h=8, w=8, b=1, dtype=dtype)
    outputs = unroll(model, buffers, 2)
    reference = model.reference({name: values[:, -2:] for name, values in buffers.items()})
    loss = (outputs - reference).abs().mean()
    assert loss.isfinite()
    assert model.present(outputs[:, 0], Frame.from_clip(buffers, 1)).isfinite().all()
    if loss.requires_grad:
        loss.backward()
        gradients = [weight.grad for weight in model.parameters() if weight.grad is not None]
        assert gradients
        assert all(gradient.dtype == dtype and gradient.isfinite().all() for gradient in gradients)
