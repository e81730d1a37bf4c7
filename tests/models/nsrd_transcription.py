"""A second implementation of NSRD, from sections 3.1 to 3.3 and figure 2 of its paper, without shared code.

Everything is one clip ``(C, h, w)`` in float64; sampling is a loop over pixels.
"""

import math

import torch
import torch.nn.functional as F


def sample(image, x, y):
    """Return the bilinear sample at a position in units of the image, with borders repeated."""
    _, h, w = image.shape
    x, y = min(max(x * w - 0.5, 0.0), w - 1.0), min(max(y * h - 0.5, 0.0), h - 1.0)
    j, i = min(math.floor(x), w - 1), min(math.floor(y), h - 1)
    a, b = x - j, y - i
    right, below = min(j + 1, w - 1), min(i + 1, h - 1)
    top = (1 - a) * image[:, i, j] + a * image[:, i, right]
    return (1 - b) * top + b * ((1 - a) * image[:, below, j] + a * image[:, below, right])


def warp(image, vectors, shift=(0.0, 0.0)):
    """Warp by ``vectors``; ``shift`` is that of the samples between the two images, in units of the image."""
    _, h, w = vectors.shape
    out = torch.empty(image.shape[0], h, w, dtype=image.dtype)
    for i in range(h):
        for j in range(w):
            dx, dy = vectors[:2, i, j].tolist()
            out[:, i, j] = sample(image, (j + 0.5) / w + dx + shift[0], (i + 0.5) / h + dy + shift[1])
    return out


def enlarge(vectors, s, offset=(0.0, 0.0)):
    """Upsample bilinearly; ``offset`` is that of the samples from the pixel centres, in units of the image."""
    c, h, w = vectors.shape
    out = torch.empty(c, h * s, w * s, dtype=vectors.dtype)
    for i in range(h * s):
        for j in range(w * s):
            out[:, i, j] = sample(vectors, (j + 0.5) / (w * s) - offset[0], (i + 0.5) / (h * s) - offset[1])
    return out


def conv(x, layer):
    return F.conv2d(x[None], layer.weight, layer.bias, padding=layer.kernel_size[0] // 2)[0]


def block(x, b):
    inner = conv(conv(x, b.first).clamp_min(0), b.second)
    mean = inner.mean((1, 2), keepdim=True)
    factor = torch.sigmoid(conv(conv(mean, b.attention.squeeze).clamp_min(0), b.attention.excite))
    return x + inner * factor


def several(x, blocks):
    for b in blocks:
        x = block(x, b)
    return x


def pool(x):
    c, h, w = x.shape
    return torch.stack(
        [
            x[:, 2 * i : 2 * i + 2, 2 * j : 2 * j + 2].reshape(c, 4).amax(1)
            for i in range(h // 2)
            for j in range(w // 2)
        ],
        1,
    ).reshape(c, h // 2, w // 2)


def u_shape(x, u):
    full = several(x, u.down1)
    half = several(pool(full), u.down2)
    x = several(pool(half), u.centre)
    x = several(conv(torch.cat((fit(x, half), half)), u.join2), u.up2)
    return several(conv(torch.cat((fit(x, full), full)), u.join1), u.up1)


def fit(x, like):
    x = enlarge(x, 2)
    rows = [min(i, x.shape[1] - 1) for i in range(like.shape[1])]
    columns = [min(j, x.shape[2] - 1) for j in range(like.shape[2])]
    return x[:, rows][:, :, columns]


def shuffle(x, s):
    """Move channel ``c s^2 + i s + j`` to row ``i`` and column ``j`` of each block of output channel ``c``."""
    out = torch.empty(x.shape[0] // s**2, x.shape[1] * s, x.shape[2] * s, dtype=x.dtype)
    for k in range(x.shape[0]):
        out[k // s**2, k % s**2 // s :: s, k % s :: s] = x[k]
    return out


def unshuffle(x, s):
    return torch.stack([x[k // s**2, k % s**2 // s :: s, k % s :: s] for k in range(x.shape[0] * s**2)])


def lighting(frame):
    return (frame["radiance"] - frame["emission"]) / frame["material"]


def offset(frame, located):
    """Return the offset of a frame's samples from the pixel centres, in units of the image."""
    _, h, w = frame["depth"].shape
    return (frame["jitter"] / torch.tensor([w, h])).tolist() if located else (0.0, 0.0)


def planes(frame):
    _, h, w = frame["depth"].shape
    return frame["jitter"][:, None, None].expand(2, h, w)


def apart(here, there):
    return here[0] - there[0], here[1] - there[1]


def outputs(model, frames, located=False, based=False):
    """Return the outputs of a clip, a list of buffers ``(C, h, w)`` by name; the model has 2 previous frames.

    ``located``: samples are known to lie at pixel centre + jitter; every point is followed at its position.
    ``based``: the network adds to the samples' bilinear interpolation.
    """
    s, results, inputs, hidden, cell = model.scale, [], [], None, None
    offsets = [offset(frame, located) for frame in frames]
    for t, frame in enumerate(frames):
        _, h, w = frame["depth"].shape
        known = (planes(frame),) if located else ()
        inputs.append(torch.cat((lighting(frame), frame["depth"], frame["normal"], *known)))
        shallow = [conv(inputs[t], model.first)]
        # Each pixel is followed back through the frames; the first frame stands in for those before it, without motion.
        back, hidden_by = torch.zeros(2, 2, h, w).double()
        for k in (1, 2):
            source, i = max(t - k, 0), t - k + 1
            if i > 0:
                there = torch.cat((frames[i]["motion"], frames[i]["motion_dual"] - frames[i]["motion"]))
                step = there if k == 1 else warp(there, back, apart(offsets[t], offsets[i]))
                back, hidden_by = back + step[:2], hidden_by + step[2:]
            mask = ((hidden_by[:1].abs() * w >= 0.1) | (hidden_by[1:].abs() * h >= 0.1)).double()
            masked = torch.cat((warp(inputs[source], back, apart(offsets[t], offsets[source])), mask))
            weight, bias = model.gated.both.weight, model.gated.both.bias
            features = F.conv2d(masked[None], weight[:32], bias[:32], padding=1)[0]
            gate = F.conv2d(masked[None], weight[32:], bias[32:], padding=1)[0]
            shallow.append(F.leaky_relu(features, 0.2) * torch.sigmoid(gate))
        before = torch.zeros(3, h * s, w * s).double()
        if t:
            before = warp(results[-1], enlarge(frame["motion"], s, offsets[t]))
        shallow.append(conv(unshuffle(before, s), model.recur.first))
        if t == 0:
            hidden = cell = torch.zeros(64, h, w).double()
        write, keep, show, value = conv(torch.cat((*shallow, hidden)), model.recur.lstm.gates).split(64)
        cell = torch.sigmoid(keep) * cell + torch.sigmoid(write) * torch.tanh(value)
        hidden = torch.sigmoid(show) * torch.tanh(cell)
        top = model.reconstruct
        results.append(shuffle(conv(conv(u_shape(hidden, top.body), top.narrow), top.last), s))
        if based:
            results[t] = results[t] + enlarge(lighting(frame), s, offset(frame, True))
    return torch.stack(results)
