import numpy as np
import pytest
import torch
import torchvision

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.stages.flow import RAFT, TVL1, JitteredMotionVectors, MotionVectors, NoFlow, compensate_jitter


def scene(x, y):
    """Return a smooth brightness for every point of the plane, in pixels."""
    return 0.5 + 0.2 * torch.sin(0.45 * x + 0.2 * y) + 0.2 * torch.cos(0.15 * x - 0.5 * y)


def shot(shift, jitter, h=40, w=48):
    """Return the plane moved by ``shift`` pixels, sampled at pixel centres + jitter: ``(1, 3, h, w)``."""
    x = torch.arange(w)[None, :] + 0.5 + jitter[0] - shift[0]
    y = torch.arange(h)[:, None] + 0.5 + jitter[1] - shift[1]
    return scene(x, y).expand(1, 3, h, w)


def test_compensation_finds_the_unjittered_motion_of_a_moved_plane():
    """The position of a sample's point in the previous image, computed from positions on the plane."""
    h, w = 3, 5
    jitter, previous, velocity = (torch.tensor([[0.3, -0.2]]), torch.tensor([[-0.4, 0.1]]), torch.tensor([1.5, -0.75]))
    jittered = torch.empty(1, 2, h, w)
    for i in range(h):
        for j in range(w):
            sample = torch.tensor([j + 0.5, i + 0.5]) + jitter[0]
            index_before = sample - velocity - previous[0]  # of the pixel (centre) that sampled this point before
            jittered[0, :, i, j] = (index_before - torch.tensor([j + 0.5, i + 0.5])) / torch.tensor([w, h])
    expected = (-velocity / torch.tensor([w, h])).view(1, 2, 1, 1).expand(1, 2, h, w)
    torch.testing.assert_close(compensate_jitter(jittered, jitter, previous), expected)


def test_gradient_of_compensation():
    motion = torch.randn(2, 2, 3, 4, dtype=torch.float64, requires_grad=True)
    jitters = [torch.rand(2, 2, dtype=torch.float64, requires_grad=True) for _ in range(2)]
    assert torch.autograd.gradcheck(compensate_jitter, (motion, *jitters))


def test_motion_vectors_are_returned_unchanged():
    motion = torch.randn(2, 2, 3, 4)
    stage = MotionVectors()
    assert stage.remember(Frame(motion=motion)) == ()
    assert stage(Frame(motion=motion), ()) is motion


def test_jittered_motion_vectors_lose_the_jitter():
    motion, jitters = torch.randn(2, 2, 3, 4), torch.rand(2, 2, 2) - 0.5
    stage = JitteredMotionVectors()
    memory = stage.remember(Frame(motion=motion, jitter=jitters[0]))
    result = stage(Frame(motion=motion, jitter=jitters[1]), memory)
    for n in range(2):
        x = motion[n, 0] + (jitters[0, n, 0] - jitters[1, n, 0]) / 4
        y = motion[n, 1] + (jitters[0, n, 1] - jitters[1, n, 1]) / 3
        torch.testing.assert_close(result[n], torch.stack((x, y)))


@pytest.mark.parametrize("velocity", [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8), (0.0, 0.0)])
def test_tvl1_finds_the_motion_of_a_jittered_plane(velocity):
    now, before = torch.tensor([[0.3, -0.4]]), torch.tensor([[-0.35, 0.2]])
    stage = TVL1()
    memory = stage.remember(Frame(color=shot((0.0, 0.0), before[0]), jitter=before))
    flow = stage(Frame(color=shot(velocity, now[0]), jitter=now), memory)
    pixels = flow * torch.tensor([48.0, 40.0]).view(1, 2, 1, 1)
    inner = pixels[0, :, 8:-8, 8:-8].flatten(1).median(dim=1).values.numpy()
    np.testing.assert_allclose(inner, [-v for v in velocity], atol=0.1)


def test_tvl1_does_not_mix_items_and_has_no_gradient():
    a, b = shot((0, 0), (0, 0)), shot((1.0, 0.5), (0, 0))
    zeros = torch.zeros(2, 2)
    both = TVL1()(Frame(color=torch.cat((b, a)).requires_grad_(), jitter=zeros), (torch.cat((a, a)), zeros))
    alone = TVL1()(Frame(color=b, jitter=zeros[:1]), (a, zeros[:1]))
    assert torch.equal(both[:1], alone)
    assert not both.requires_grad


def test_tvl1_of_tiny_images_is_zero_motion():
    jitter = torch.zeros(1, 2)
    flow = TVL1()(Frame(color=torch.rand(1, 3, 1, 3), jitter=jitter), (torch.rand(1, 3, 1, 3), jitter))
    assert torch.equal(flow, torch.zeros(1, 2, 1, 3))


class Stub(torch.nn.Module):
    """A stand-in for RAFT that records its inputs, and returns a flow that ``answer`` computes from the two images."""

    def __init__(self, answer):
        super().__init__()
        self.answer, self.inputs = answer, []

    def forward(self, first, second, num_flow_updates):
        self.inputs.append((first, second, num_flow_updates))
        return [torch.full_like(first[:, :2], torch.nan), self.answer(first, second)]


def stub(answer, network="raft_small", weights="C_T_V2", updates=3):
    stage = RAFT(network, weights, updates)
    stage.network = Stub(answer)
    return stage


def constant(x, y):
    return lambda first, second: torch.tensor([x, y]).view(1, 2, 1, 1).expand(len(first), 2, *first.shape[-2:])


def search(first, second):
    """Return the flow with ``first(p) = second(p + flow)``, found by trial of whole pixels."""
    reach, inner = 9, (..., slice(40, -40), slice(40, -40))
    candidates = [(x, y) for x in range(-reach, reach + 1) for y in range(-reach, reach + 1)]
    errors = [(second.roll((-y, -x), (2, 3)) - first)[inner].abs().mean() for x, y in candidates]
    return constant(*map(float, candidates[int(torch.stack(errors).argmin())]))(first, second)


@pytest.mark.parametrize(("h", "w", "factor"), [(160, 136, 1), (32, 48, 3)])
def test_flow_of_raft_is_from_current_to_previous_in_pixels(raft, h, w, factor):
    """A jittered plane that moves, so that its image moves by whole pixels of the network's input."""
    now, before, velocity = (0.25, -0.5), (-0.25, 0.0), (1.5, -1.5)
    images = [shot((0.0, 0.0), before, h, w), shot(velocity, now, h, w)]
    stage = stub(search)
    memory = stage.remember(Frame(color=images[0], jitter=torch.tensor([before])))
    flow = stage(Frame(color=images[1], jitter=torch.tensor([now])), memory)
    expected = torch.tensor([-v / size for v, size in zip(velocity, (w, h))]).view(1, 2, 1, 1)
    torch.testing.assert_close(flow, expected.expand(1, 2, h, w), rtol=0, atol=1e-6)
    first, _, updates = stage.network.inputs[0]
    assert updates == 3
    assert all(side >= 128 and side % 8 == 0 for side in first.shape[-2:])
    assert max(h, w) * factor <= max(first.shape[-2:])


@pytest.mark.parametrize(("h", "w", "factor"), [(131, 201, 1), (24, 33, 4), (1, 3, 43), (5, 1, 26), (140, 2, 1)])
def test_flow_of_raft_is_cropped_at_the_position_of_the_image(raft, h, w, factor):
    """If the flow equals the image's values, the result has them at their positions: means of enlarged pixels."""
    torch.manual_seed(0)
    color, still = torch.rand(2, 3, h, w), torch.zeros(2, 2)
    stage = stub(lambda first, second: first[:, :2])
    flow = stage(Frame(color=color, jitter=still), (torch.rand(2, 3, h, w), still))
    rows, columns = ((torch.arange(n * factor) + 0.5) / factor - 0.5 for n in (h, w))
    for n in range(2):
        for c, size in ((0, w), (1, h)):
            # Bilinear with repeated borders, by numpy; then the mean of each block.
            wide = np.stack([np.interp(columns, np.arange(w), row) for row in color[n, c].numpy()])
            tall = np.stack([np.interp(rows, np.arange(h), column) for column in wide.T], axis=1)
            mean = tall.reshape(h, factor, w, factor).mean((1, 3))
            np.testing.assert_allclose(flow[n, c] * size * factor, 2 * mean - 1, atol=1e-4)


def test_raft_reads_colours_in_minus_1_to_1_with_repeated_borders(raft):
    color = torch.rand(1, 3, 130, 140)
    stage = stub(constant(0.0, 0.0))
    stage(Frame(color=color, jitter=torch.zeros(1, 2)), (1.0 - color, torch.zeros(1, 2)))
    first, second, _ = stage.network.inputs[0]
    assert first.shape == (1, 3, 136, 144)
    np_padded = np.pad(2 * color[0].numpy() - 1, ((0, 0), (3, 3), (2, 2)), mode="edge")
    np.testing.assert_allclose(first[0], np_padded, atol=1e-6)
    np.testing.assert_allclose(second[0], -np_padded, atol=1e-6)


@pytest.mark.parametrize(("network", "weights"), [("raft_large", "C_T_SKHT_V2"), ("raft_small", "C_T_V2")])
def test_raft_has_no_parameters_and_saves_no_weights(raft, network, weights):
    stage = RAFT(network, weights, 1).train()
    assert not list(stage.parameters())
    assert not stage.state_dict()
    assert not any(module.training for module in stage.network.modules())
    before = [values.clone() for values in stage.buffers()]
    color, still = torch.rand(2, 3, 20, 24, requires_grad=True), torch.zeros(2, 2)
    previous_color = torch.rand(2, 3, 20, 24)
    flow = stage(Frame(color=color, jitter=still), (previous_color, still))
    assert flow.shape == (2, 2, 20, 24)
    assert flow.isfinite().all()
    assert not flow.requires_grad
    assert all(torch.equal(a, b) for a, b in zip(before, stage.buffers()))
    with torch.autocast("cpu", torch.bfloat16):
        assert torch.equal(stage(Frame(color=color, jitter=still), (previous_color, still)), flow)
    alone = stage(Frame(color=color[1:], jitter=still[1:]), (previous_color[1:], still[1:]))
    assert torch.equal(alone, flow[1:])


def test_raft_equals_torchvision_with_weights_of_the_file(raft, raft_home):
    """At a size that needs no padding, against the network itself."""
    torch.manual_seed(0)
    color, previous_color, still = torch.rand(1, 3, 128, 136), torch.rand(1, 3, 128, 136), torch.zeros(1, 2)
    network = torchvision.models.optical_flow.raft_small(weights=None).eval()
    entry = torchvision.models.optical_flow.Raft_Small_Weights.C_T_V2
    network.load_state_dict(torch.load(raft_home / "hub" / "checkpoints" / entry.url.split("/")[-1], weights_only=True))
    with torch.no_grad():
        expected = network(*entry.transforms()(color, previous_color), num_flow_updates=4)[-1]
    flow = RAFT("raft_small", "C_T_V2", 4)(Frame(color=color, jitter=still), (previous_color, still))
    assert expected.abs().max() > 1e-3
    torch.testing.assert_close(flow * torch.tensor([136.0, 128.0]).view(1, 2, 1, 1), expected)


def test_missing_weights_of_raft_are_named(monkeypatch, tmp_path):
    def offline(*args, **kwargs):
        raise OSError("<urlopen error no route to host>")

    monkeypatch.setattr(torch.hub, "download_url_to_file", offline)
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    path = f"{tmp_path}/hub/checkpoints/raft_large_C_T_SKHT_V2-ff5fadd5.pth"
    with pytest.raises(UserError, match=f"no route to host.*C_T_SKHT_V2-ff5fadd5.pth at {path}, or use .*tvl1"):
        RAFT("raft_large", "C_T_SKHT_V2", 12)


def test_invalid_settings_of_raft_raise():
    with pytest.raises(UserError, match=r"Unknown flow\.network=vgg16: use raft_large or raft_small"):
        RAFT("vgg16", "IMAGENET1K_V1", 12)
    with pytest.raises(
        UserError, match="Unknown weights C_T_SKHT_V2 of torchvision.s raft_small: use one of C_T_V1, C_T_V2"
    ):
        RAFT("raft_small", "C_T_SKHT_V2", 12)
    with pytest.raises(UserError, match=r"Invalid flow\.updates=0: use at least 1"):
        RAFT("raft_small", "C_T_V2", 0)


def test_no_flow_reads_nothing_and_returns_none():
    assert NoFlow.requires == frozenset()
    assert NoFlow()(Frame(), ()) is None
