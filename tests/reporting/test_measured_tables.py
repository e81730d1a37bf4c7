"""The papers' tables of times, cell by cell, from made-up benchmarks that ran the tables' own commands."""

import math
import shlex
from dataclasses import replace

import pytest
from made_up_benchmarks import MadeUpStore, number

from supersampling.commands.benchmark import check_settings
from supersampling.reporting.papers.published import load_papers
from supersampling.reporting.papers.tables import NO_PART, NOT_AVAILABLE, NOT_RUN, TableRuns, fill
from supersampling.reporting.papers.times import quantity_of, table_times
from supersampling.resources import resources
from supersampling.runs.measurements import read_measurements

PAPERS = {paper.paper: paper for paper in load_papers(resources() / "reports" / "published", None)}
HD = "1920x1080"


def table_of(paper, name):
    (table,) = [table for table in PAPERS[paper].tables if table.number == name]
    return table


def filled(paper, name, store=None, table=None):
    """Return our numbers of a table by the labels of row and column, and the filled table."""
    table = table or table_of(paper, name)
    store = store or MadeUpStore(table.command)
    times = table_times(table, PAPERS[paper].metrics, read_measurements(store, "0"))
    result = fill(TableRuns(table, {}, {}, [], times), PAPERS[paper], {})
    cells = {}
    for (row, column, _), value in result.values.items():
        assert math.isnan(value.half_width)
        cells["/".join(table.rows[row].labels), table.columns[column].label] = value.mean
    return cells, result


def at(name, backend, *parts, scale=4, size=HD):
    """Return the sum of made-up numbers of a method's parts; a part with a minus is subtracted."""
    terms = [(-1 if part.startswith("-") else 1, part.removeprefix("-")) for part in parts]
    return sum(sign * number(name, scale, size, backend, "float32", part) for sign, part in terms)


def faster(names, backends, *parts, scales=(4,), sizes=(HD,)):
    """Return the backend whose sum over all cells is least: of one command's backends the table shows this one."""
    sums = {b: sum(at(n, b, *parts, scale=k, size=z) for n in names for k in scales for z in sizes) for b in backends}
    return min(sums, key=lambda backend: sums[backend])


def test_nsrr_1_network_by_size():
    sizes = {"1280×720": "1280x720", "1080×1200": "1080x1200", "1920×1080": HD}
    names = {"Ours": "nsrr", "Ours-Fast": "nsrr_fast"}
    backend = faster(names.values(), ("channels_last", "onnxruntime"), "whole", sizes=sizes.values())
    cells, _ = filled("nsrr", "1")
    assert cells == pytest.approx(
        {(r, c): at(name, backend, "whole", size=size) for r, name in names.items() for c, size in sizes.items()}
    )


NSRR_MODULES = {
    "Feature extraction": ("extract", "previous_frames.extract"),
    "Motion vector upsampling": ("previous_frames.warp_at.upsample_motion",),
    "Feature zero-upsampling": ("upsample", "previous_frames.upsample"),
    "Warping": ("previous_frames.warp_at", "-previous_frames.warp_at.upsample_motion"),
    "Feature reweighting": ("previous_frames.reweight",),
    "Reconstruction": ("reconstruct",),
    "Total": ("total",),
}


def test_nsrr_2_modules():
    cells, _ = filled("nsrr", "2")
    names = {"Ours": "nsrr", "Ours-Fast": "nsrr_fast"}
    sums = {
        backend: {(r, c): at(n, backend, *parts) for r, parts in NSRR_MODULES.items() for c, n in names.items()}
        for backend in ("eager", "channels_last")
    }
    assert cells == pytest.approx(min(sums.values(), key=lambda values: sum(values.values())))


def test_nsrr_5_previous_frames():
    cells, _ = filled("nsrr", "5")
    names = {str(n): f"nsrr previous={n}" for n in range(4)} | {"4": "nsrr"}
    backend = faster(names.values(), ("channels_last", "onnxruntime"), "whole")
    assert cells == pytest.approx({(n, "Runtime (ms)"): at(name, backend, "whole") for n, name in names.items()})


def test_nsrr_frame_budget():
    size = "1600x900"
    cells, result = filled("nsrr", "rendering efficiency")
    network = min(at("nsrr", backend, "whole", size=size) for backend in ("channels_last", "onnxruntime"))
    full, low = number("full", 1, size, "render"), number("nsrr", 4, size, "render")
    first, second = "rendered at 1600×900", "rendered at 400×225, then Ours"
    assert cells == pytest.approx(
        {
            (first, "rendering"): full, (first, "upsampling"): 0.0, (first, "total"): full,
            (second, "rendering"): low, (second, "upsampling"): network, (second, "total"): low + network,
        }
    )  # fmt: skip
    assert result.measured.endswith("rendering by llvmpipe")


def test_enss_1_stages():
    cells, result = filled("enss", "1")
    columns = [("Ours-S", "enss_s", (2,)), ("Ours-M", "enss_m", (2, 3, 4)), ("Ours-L", "enss_l", (2, 3, 4))]
    dilation, warping = "_predict._previous.motion_grid", "_predict._previous.reproject"
    rows = {
        "MV dilation": (dilation,),
        "Warping": (warping,),
        "Neural network": ("total", f"-{dilation}", f"-{warping}"),
        "Total": ("total",),
    }
    xiao = {
        "Warping": ("previous_frames.warp_at",),
        "Neural network": ("total", "-previous_frames.warp_at"),
        "Total": ("total",),
    }
    sums = {}
    for backend in ("eager", "channels_last"):
        sums[backend] = {
            (row, f"{label} {k}×{k}"): at(name, backend, *parts, scale=k)
            for label, name, scales in columns
            for k in scales
            for row, parts in rows.items()
        } | {
            (row, f"Xiao et al. {k}×{k}"): at("nsrr", backend, *parts, scale=k)
            for k in (2, 3, 4)
            for row, parts in xiao.items()
        }
    assert cells == pytest.approx(min(sums.values(), key=lambda values: sum(values.values())))
    metric = PAPERS["enss"].metrics["ms"]
    assert [result.state(0, column, metric) for column in (7, 8, 9)] == [NO_PART] * 3


def test_nsrd_3_stages():
    cells, _ = filled("nsrd", "3")
    warps = ("chain", "warp_previous.warp", "warp_previous.motion_mask", "upsample_motion", "recur.warp")
    high, low = (number("nsrd", 4, HD, part) for part in ("render.high", "render.g_buffers"))
    sums = [
        {
            ("Time (ms)", "HR_M"): high,
            ("Time (ms)", "LR_G"): low,
            ("Time (ms)", "Warping"): at("nsrd", backend, *warps),
            ("Time (ms)", "Inference"): at("nsrd", backend, "total", *(f"-{part}" for part in warps)),
            ("Time (ms)", "Total"): high + low + at("nsrd", backend, "total"),
        }
        for backend in ("eager", "channels_last")
    ]
    assert cells == pytest.approx(min(sums, key=lambda values: sum(values.values())))


def test_nsrd_s2_modules_against_the_supplement():
    """The supplement's own numbers, which it truncates; its second row counts shared weights twice."""
    cells, result = filled("nsrd", "S2", MadeUpStore(table_of("nsrd", "3").command))
    assert "rendering" not in result.measured  # which that command timed as well
    table = table_of("nsrd", "S2")
    for row in table.rows:
        for column, (published,) in zip(table.columns, row.values):
            if published is not None:
                ours = cells["/".join(row.labels), column.label]
                twice = 2 if (row.labels[0], column.label) == ("Reliable Warping", "Params (K)") else 1
                assert twice * ours == pytest.approx(published, abs=0.011)
    assert len(cells) == 12


LAYERS = {
    "Down": "network.down",
    **{f"Res Block {k + 1}": f"network.blocks.{k}" for k in range(4)},
    "Up": "network.up",
    "Total": "network",
}
OPTIMISATIONS = {"None": "eager", "1": "thesis_1", "1 & 2": "thesis_1_2"}


def test_thesis_6_layers():
    cells, _ = filled("dlctus", "6")
    block = "network.blocks.0"
    parts = {
        "Conv3x3 and ReLU": (f"{block}.0", f"{block}.1"),
        "Conv3x3": (f"{block}.2",),
        "Add": (f"{block}.(its own)",),
        "Total": (block,),
    }
    assert cells == pytest.approx({("time (µs)", c): 1000 * at("dlctus", "eager", *p) for c, p in parts.items()})


def test_thesis_7_network():
    cells, result = filled("dlctus", "7")
    expected = {
        (row, column): 1000 * at("dlctus", backend, part)
        for row, backend in OPTIMISATIONS.items()
        for column, part in LAYERS.items()
        if column != "Up" or row == "None"
    }
    assert cells == pytest.approx(expected)
    metric = PAPERS["dlctus"].metrics["stage_time"]
    assert [result.state(row, 5, metric) for row in (1, 2)] == [NO_PART] * 2


def test_thesis_8_total():
    cells, _ = filled("dlctus", "8")
    parts = {"Input Preparation": "prepare_input", "Network Execution": "network", "Total": "total"}
    expected = {}
    for row, backend in OPTIMISATIONS.items():
        construct = "construct" if backend == "eager" else "construct_image"
        for k in (4, 2):
            for column, part in (parts | {"Output Construction": construct}).items():
                expected[f"{k}×{k}/{row}", column] = 1000 * at("dlctus", backend, part, scale=k)
    assert cells == pytest.approx(expected)


def test_thesis_12_reprojection():
    cells, _ = filled("dlctus", "12")
    names = {"Bilinear": "dlctus reproject=bilinear", "Bicubic5": "dlctus reproject=bicubic5", "Bicubic9": "dlctus"}
    assert cells == pytest.approx(
        {
            (f"{k}×{k}", column): 1000 * at(name, "thesis_1_2", "prepare_input", scale=k)
            for k in (4, 2)
            for column, name in names.items()
        }
    )


MEASURED = [(name, table.number) for name, paper in PAPERS.items() for table in paper.tables if table.command]


@pytest.mark.parametrize(("paper", "number_of_table"), MEASURED)
def test_command_of_a_table_composes_and_fills_it(paper, number_of_table, entry):
    table = table_of(paper, number_of_table)
    program, command, *words = shlex.split(table.command)
    assert (program, command) == ("python", "benchmark.py")
    check_settings(entry("benchmark", *words))
    _, result = filled(paper, number_of_table)
    metrics = PAPERS[paper].metrics
    states = {
        result.state(row, column, metrics[name])
        for row, column in table.selections
        for name in table.columns[column].metrics
        if quantity_of(metrics[name].logged) and (row, column, name) not in result.values
    }
    assert states <= {NO_PART}
    assert (states == {NO_PART}) == ((paper, number_of_table) in {("enss", "1"), ("dlctus", "7")})


def test_a_method_that_the_project_lacks_is_not_available():
    table = table_of("nsrr", "4")
    assert filled("nsrr", "4", MadeUpStore())[1].state(4, 0, PAPERS["nsrr"].metrics["psnr"]) == NOT_AVAILABLE
    assert table.columns[0].label == "ESPCN"


def test_a_table_is_of_one_benchmark():
    """A newer one that fills fewer cells does not replace it, nor mix with it; an equal newer one does."""
    command = table_of("dlctus", "8").command
    fewer = command.replace("scales=[2,4]", "scales=[4]")
    cells, result = filled("dlctus", "8", MadeUpStore(command, fewer))
    assert {runs[0].id for runs in result.runs.values()} == {"bench0"}
    assert len(cells) == 24
    _, result = filled("dlctus", "8", MadeUpStore(command, command))
    assert {runs[0].id for runs in result.runs.values()} == {"bench1"}


def test_cells_that_were_not_measured():
    fewer = table_of("dlctus", "7").command.replace(",thesis_1_2", "")
    cells, result = filled("dlctus", "7", MadeUpStore(fewer))
    assert {row for row, _ in cells} == {"None", "1"}
    assert result.state(2, 0, PAPERS["dlctus"].metrics["stage_time"]) == NOT_RUN


def test_lower_precision_needs_to_be_named():
    table = table_of("nsrr", "1")
    store = MadeUpStore(table.command + " precisions=[bfloat16]")
    assert filled("nsrr", "1", store)[0] == {}
    named = replace(table, base={**table.base, "precision": "bfloat16"})
    assert len(filled("nsrr", "1", store, named)[0]) == 6
