"""Every row of every ablation table of the papers, as a command line: it composes, and a step of its training runs.

Rows are what ``train.py`` is given after the table's own words. Only the budget is another: the smallest, on clips of a
few pixels with exactly the buffers that the configured model, loss and choice of windows read.
"""

from functools import cache

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate
from model_cases import CONF, clip
from omegaconf import OmegaConf

from supersampling.frames import BUFFERS
from supersampling.training.module import Training
from supersampling.training.numbers import check_numbers

SHARP = "task.scale=2 task.mip_bias=sharp"  # the thesis's data set 2
TWO = "task.scale=2"
DATA_SETS = {"4, 1": "", "2, 1": TWO, "2, 2": SHARP}  # f_u, data set
SCENES = ["atrium", "bar", "market", "foundry", "arena", "airstrip", "louvres", "sundial", "turntable", "stk/zengarden"]


def fewer(count):
    return f"scene=[{','.join(SCENES[: len(SCENES) - count])}]"


def crossed(slot, options, data_sets=DATA_SETS):
    """A DLCTUS table with a column for each option of a stage and a row for each factor and data set."""
    return {
        f"{option}, {key}": f"model/{slot}={option} {task}" for key, task in data_sets.items() for option in options
    }


# {table: (its command, {row: what the row adds})}. A name that sweeps/ has too holds the same table (`test_sweeps`).
TABLES = {
    # Xiao et al. 2020
    "nsrr_table3": ("experiment=nsrr", {"Ours": "", "Ours-Fast": "model=nsrr_fast"}),
    "nsrr_table5": ("experiment=nsrr", {f"{n} previous frames": f"model.previous={n}" for n in range(5)}),
    "nsrr_table6": ("experiment=nsrr", {f"{s}x{s}": f"task.scale={s}" for s in (6, 5, 4, 3, 2)}),
    "nsrr_table9": (
        "experiment=nsrr",
        {
            "low-res, then bilinear": "model/warp_at=low model/upsample=bilinear",
            "low-res, then zero": "model/warp_at=low model/upsample=zero",
            "bilinear, then high-res": "model/warp_at=target model/upsample=bilinear",
            "zero, then high-res": "model/warp_at=target model/upsample=zero",
        },
    ),
    "nsrr_table10": (
        "experiment=nsrr",
        {
            f"extraction {e}, reweighting {r}": f"model/extract={e} model/reweight={r}"
            for e in ("none", "learned")
            for r in ("none", "learned")
        },
    ),
    "nsrr_colour_space": (
        "experiment=nsrr",  # section 3.2.5
        {space: f"model/colour_space={space}" for space in ("ycbcr", "rgb")},
    ),
    # Li et al. 2024. Its NSRR has 2 previous frames (section 4.2); "+GBuffer" is without demodulation, "+Demod." with
    # both.
    "nsrd_table5_nsrr": (
        "experiment=nsrd model=nsrr model.previous=2 loss=nsrr",
        {
            "as published": "",
            "+GBuffer": "model/guides=gbuffers",
            "+Demod.": "model/guides=gbuffers model/demodulate=lighting",
            "demodulation alone": "model/demodulate=lighting",
            "radiance, all material buffers": "model/demodulate=none model/guides=gbuffers "
            "model.guides.names=[normal,albedo,metallic,roughness,specular,n_dot_v]",
        },
    ),
    "nsrd_table5": ("experiment=nsrd", {"+GBuffer": "model/demodulate=none", "+Demod.": ""}),
    "nsrd_table6": (
        "experiment=nsrd",
        {
            "A": "model/recur=none loss.weights.masked_temporal=0",
            "B": "loss.weights.masked_temporal=0",
            "temporal loss alone": "model/recur=none",
            "Ours": "",
        },
    ),
    "nsrd_figure8": ("experiment=nsrd", {"without mask": "model/motion_mask=none", "with mask": ""}),
    "nsrd_tableS4": ("experiment=nsrd", {f"{s}x{s}": f"task.scale={s}" for s in (2, 4, 6)}),
    # Mercier et al. 2023
    "enss_table2": (
        "experiment=enss",
        {f"Ours-{size.upper()}, {s}x{s}": f"model=enss_{size} task.scale={s}" for size in "sml" for s in (2, 3, 4)},
    ),
    "enss_table3": (
        f"experiment=enss {fewer(0)}",
        {
            "Baseline (f32-m3)": "",
            "(-) MV dilation": "model/motion_grid=bilinear",
            "(-) blending": "model/history=unblended",
            "(-) jitter": "task.jitter=none",
            "(-) MVs, (+) RAFT": "model/flow=raft",
            "(-) MVs, (+) TV-L1": "model/flow=tvl1",
            "(-) warping": "model/flow=none",
            "(-) multiple frames": "model/history=none",
            "(-) first jitter conv": "model/kernel_prediction=last",
            "(-) last jitter conv": "model/kernel_prediction=first",
            "(-) jitter conv": "model/kernel_prediction=none",
            "(-2) training scenes": fewer(2),
            "(-5) training scenes": fewer(5),
            "(-8) training scenes": fewer(8),
            "(+) perceptual loss": "loss=nsrr",
        },
    ),
    # Swensen 2021
    "dlctus_table2": ("experiment=dlctus", DATA_SETS),
    # Section 4.5 gives it the recipe of Xiao et al., without their YCbCr.
    "dlctus_table2_xiao": ("model=nsrr recipe=dlctus model/colour_space=rgb loss=nsrr", DATA_SETS),
    "dlctus_table10": (
        f"experiment=dlctus {SHARP}",
        {"L1": "loss=l1"} | {f"theta {t}": f"loss=spatiotemporal loss.theta={t}" for t in (0.1, 0.5, 0.9)},
    ),
    "dlctus_table13": ("experiment=dlctus", crossed("reproject", ("bilinear", "bicubic5", "bicubic9"))),
    "dlctus_table14": ("experiment=dlctus", crossed("dilate", ("closest", "none"))),
    "dlctus_table16": ("experiment=dlctus", crossed("accumulate", ("buffer", "none"), {"4x4, 1": "", "2x2, 2": SHARP})),
}
# RAFT itself is what its size is: the small one, one update, stands for the large one in a test of seconds.
QUICK = {"model/flow=raft": "model.flow.network=raft_small model.flow.weights=C_T_V2 model.flow.updates=1"}
COMMANDS = {
    f"{table}: {row}": f"{command} {added}".strip()
    for table, (command, rows) in TABLES.items()
    for row, added in rows.items()
}
# A paper's own row stands in each of its tables: one step of it is enough.
DISTINCT = {command: name for name, command in reversed(COMMANDS.items())}


@cache
def composed(command):
    """By the entry point's own configuration, as `test_configs` does."""
    GlobalHydra.instance().clear()
    quick = " ".join(settings for option, settings in QUICK.items() if option in command.split())
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("train", ["scene=atrium", "budget=smoke", *command.split(), *quick.split()])


def sample(cfg, model, loss):
    """What the loaders would give: references and all else of high resolution for the frames that the loss sees
    alone."""
    side = -(-16 // model.scale)  # VGG-16 needs 16 target pixels, SSIM 11
    names = model.requires | model.compares | loss.requires | instantiate(cfg.pick).requires
    buffers = clip(names, model.scale, cfg.budget.frames, cfg.budget.batch, side, side + 1, dtype=torch.float32)
    if cfg.task.jitter == "none" and "jitter" in buffers:
        buffers["jitter"].zero_()
    last = slice(-(cfg.budget.counted + loss.previous), None)
    return {k: v[:, last] if BUFFERS[k].resolution == "high" else v for k, v in buffers.items()}


@pytest.mark.parametrize("command", DISTINCT, ids=DISTINCT.values())
def test_a_step_of_the_row_s_training(command, request, vgg):
    """By the configured loss, optimizer and schedule: a finite loss, and every weight that had a gradient moves."""
    cfg = composed(command)
    if "model/flow=raft" in command:
        request.getfixturevalue("raft")  # random weights
    check_numbers(cfg)
    torch.manual_seed(cfg.seed)
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    training = Training(model, loss, instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), cfg.budget.counted)
    training.log = training.log_dict = lambda *args, **kwargs: None
    made = training.configure_optimizers()
    value = training.training_step(sample(cfg, model, loss), 0)
    value.backward()
    assert value.isfinite()
    assert value > 0.0
    before = {name: p.detach().clone() for name, p in model.named_parameters()}
    made["optimizer"].step()
    made["lr_scheduler"]["scheduler"].step()
    for name, p in model.named_parameters():
        assert p.grad.isfinite().all(), name
        assert p.isfinite().all(), name
        assert torch.equal(p, before[name]) != bool(p.grad.any()), name
    assert any(p.grad.any() for p in model.parameters())


@pytest.mark.parametrize("table", TABLES)
def test_the_rows_of_a_table_are_different_programs(table):
    """A switch that did not arrive would make two rows one."""
    command, rows = TABLES[table]
    seen = {}
    for row, added in rows.items():
        cfg = composed(f"{command} {added}".strip())
        parts = {key: OmegaConf.to_container(cfg[key], resolve=True) for key in ("model", "loss", "task")}
        seen[row] = repr((parts, list(cfg.scene)))
    assert len(set(seen.values())) == len(rows)


def test_the_buffers_that_a_row_reads():
    """NSRD's table 5 and its switches, typed a second time: what is off is not rendered either."""
    read = {}
    for name in ("nsrd_table5_nsrr", "nsrd_table5", "nsrd_table6", "nsrd_figure8"):
        for row, added in TABLES[name][1].items():
            cfg = composed(f"{TABLES[name][0]} {added}".strip())
            read[f"{name}: {row}"] = instantiate(cfg.model).requires
    color, light = {"color", "jitter", "depth", "motion"}, {"radiance", "material", "emission"}
    high = {"high_material", "high_emission"}
    nsrd = {"depth", "normal", "motion", "motion_dual", "radiance"}
    assert read["nsrd_table5_nsrr: as published"] == color
    assert read["nsrd_table5_nsrr: +GBuffer"] == color | {"normal"}
    assert read["nsrd_table5_nsrr: +Demod."] == (color | {"normal"} | light | high) - {"color"}
    assert read["nsrd_table5: +GBuffer"] == nsrd
    assert read["nsrd_table5: +Demod."] == nsrd | light | high
    assert read["nsrd_table6: A"] == nsrd | light | high
    assert read["nsrd_figure8: without mask"] == (nsrd | light | high) - {"motion_dual"}
