"""What `model=M` brings: the loss, jitter and window choice of its paper, typed a second time; what wins over it."""

import itertools
import re

import pytest
from hydra.core.hydra_config import HydraConfig
from model_cases import CONF, MODELS, stems
from omegaconf import OmegaConf

from supersampling.commands.train import baselines
from supersampling.config import composed, published_stages

ST = ("spatiotemporal", "default", "edges")
# Loss, task and window choice: DLCTUS 4.3.4 and 4.2.2; NSRR 3.3, 3.4 and figure 3; NSRD 3.4 and 4.1; ENSS 3 and 5.
# Edges are this project's own, for the budgets of minutes.
CLASSICAL = ("nearest", "bilinear", "bicubic", "jau", "jau_bicubic", "tus", "tus_thesis")
RECIPES = {
    **dict.fromkeys((*CLASSICAL, "dlctus"), ST),
    **dict.fromkeys(("nsrr", "nsrr_fast"), ("nsrr", "nsrr", "uniform")),
    "nsrd": ("nsrd", "nsrd", "edges"),
    **dict.fromkeys(("enss_s", "enss_m", "enss_l"), ("l1", "qrisp", "edges")),
}
LAPTOP = ("nsrr", "nsrd", "enss_s", "enss_m", "enss_l")
JITTER = {"default": "thesis", "nsrr": "none", "nsrd": "none", "qrisp": "halton16"}


def choices(*overrides, command="train"):
    chosen = composed(command, ["scene=atrium", *overrides])
    return tuple(chosen.choices[group] for group in ("loss", "task", "pick")), chosen.cfg


def test_every_model_has_a_recipe():
    assert set(RECIPES) == set(MODELS)
    assert set(MODELS) <= set(stems("recipe"))


@pytest.mark.parametrize("model", MODELS)
def test_a_model_brings_its_recipe(model):
    chosen, cfg = choices(f"model={model}")
    assert chosen == RECIPES[model]
    assert (cfg.task.scale, cfg.task.jitter) == (4, JITTER[chosen[1]])
    assert cfg.pick._target_.endswith({"edges": "MostEdges", "uniform": "Uniform"}[chosen[2]])


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        ("model=nsrr loss=l1 task=qrisp pick=edges", ("l1", "qrisp", "edges")),
        ("model=nsrr recipe=dlctus", ST),
        ("model=nsrr data=qrisp", ("nsrr", "qrisp", "uniform")),
        ("model=nsrd budget=paper", ("nsrd", "nsrd", "uniform")),
        ("model=nsrr budget=laptop", ("nsrr", "nsrr", "uniform")),
        ("budget=laptop", ST),
        ("budget=smoke", ("spatiotemporal", "default", "uniform")),
        ("experiment=laptop/dlctus", ST),
        *((f"experiment=laptop/{name}", ("l1", "default", "edges")) for name in LAPTOP),
        ("experiment=laptop/enss_published", ("l1", "qrisp", "edges")),
        ("experiment=laptop/nsrr_published", ("nsrr", "nsrr", "edges")),
        ("experiment=laptop/nsrd_published", ("nsrd", "nsrd", "edges")),
        ("experiment=laptop/nsrr data=nsrr", ("l1", "nsrr", "edges")),
        ("experiment=nsrd/nsrr", ("nsrr", "nsrd", "edges")),
    ],
)
def test_what_wins_over_a_recipe(overrides, expected):
    assert choices(*overrides.split())[0] == expected


def test_the_user_s_sweep_over_theta():
    for theta in (0.1, 0.5):
        assert choices("model=dlctus", f"loss.theta={theta}")[1].loss.theta == theta


@pytest.mark.parametrize("model", ["nsrd", "enss_l"])
def test_baselines_run_on_the_job_s_own_task(model):
    """They are methods without a recipe, whose task would be the thesis's."""
    from hydra import compose, initialize_config_dir

    with initialize_config_dir(str(CONF), version_base="1.3"):
        cfg = compose("train", [f"model={model}", "scene=atrium", "task.scale=3"], return_hydra_config=True)
        HydraConfig.instance().set_config(cfg)
        jobs = baselines(cfg)
    HydraConfig.instance().cfg = None
    assert len(jobs) == len(cfg.baselines)
    for job, selected in jobs:
        assert job.task == cfg.task
        assert job.data == cfg.data
        assert (job.model.scale, selected["task"]) == (3, RECIPES[model][1])


@pytest.mark.parametrize("overrides", ["", "model=nsrr", "model=nsrd", "model=enss_m among=enss", "among=models"])
def test_advice_is_about_one_task(overrides):
    """A search compares compositions of several models; each is trained on the task of the command."""
    from supersampling.advice.space import read_space

    cfg = choices(*overrides.split(), command="advise")[1]
    space = read_space(cfg.among)
    first = space.compositions()[0]
    last = space.compositions()[-1]
    for words in (first.overrides, last.overrides):
        chosen, job = choices(*words)
        assert chosen[1:] == ("default", "edges")
        assert job.task == cfg.task


def test_advice_takes_the_task_of_its_data():
    assert choices("model=enss_m", "data=nsrr", command="advise")[0][1] == "nsrr"


# What a paper's own recipe keeps on any data and budget: task, scale, jitter, window choice, augmentation, camera.
PAPERS = {
    "dlctus": ("default", 4, "thesis"),
    "dlctus/xiao_published": ("default", 4, "thesis"),
    "nsrr": ("nsrr", 4, "none"),
    "nsrd": ("nsrd", 4, "none"),
    "enss": ("qrisp", 2, "halton16"),
}


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize(
    "others", ["", "data=laptop budget=laptop", "data=qrisp budget=nsrr", "data=nsrr", "data=files"]
)
def test_a_paper_s_recipe_stays_on_any_data_and_budget(paper, others):
    chosen, cfg = choices(f"experiment={paper}", *others.split())
    assert (chosen[1], cfg.task.scale, cfg.task.jitter) == PAPERS[paper]
    assert chosen[2] == "uniform"
    assert cfg.augment._target_.endswith("NoAugmentation")
    if paper == "enss":
        assert cfg.data.camera == "stops"


VARIANTS = [f"{name}/{row}" for name in ("dlctus", "nsrd", "enss_table3") for row in stems(f"experiment/{name}")]


@pytest.mark.parametrize("variant", [name for name in VARIANTS if not name.startswith("dlctus/xiao")])
def test_a_variant_joins_its_paper_s_recipe(variant):
    """It changes what it is about, and neither the data nor the schedule."""
    paper = variant.partition("/")[0].partition("_")[0]
    alone, joined = (composed("train", [f"experiment={words}"]) for words in (paper, f"[{paper},{variant}]"))
    for group in ("data", "budget", "pick", "augment", "task", "optimizer"):
        assert joined.choices[group] == alone.choices[group]
    assert joined.cfg.task.scale == alone.cfg.task.scale
    same = OmegaConf.to_yaml(joined.cfg, resolve=True) == OmegaConf.to_yaml(alone.cfg, resolve=True)
    assert same == (variant in ("nsrd/ours", "dlctus/l1", "enss_table3/baseline"))


@pytest.mark.parametrize(("task", "crop"), [("default", 256), ("thesis_2x2", 192), ("thesis_2x2_sharp", 192)])
def test_the_thesis_s_training_of_xiao(task, crop):
    """Section 4.5: 300 epochs, patches of 192 at 2x2; the rest as in their paper, without YCbCr."""
    composition = composed("train", ["experiment=dlctus/xiao_published", f"task={task}"])
    budget = composition.cfg.budget
    assert (budget.epochs, budget.crop, budget.batch, budget.lr) == (300, crop, 8, 1e-4)
    assert (composition.choices["model"], composition.choices["model/colour_space"]) == ("nsrr", "rgb")
    assert (composition.choices["loss"], composition.choices["data"], composition.cfg.task.jitter) == (
        "nsrr",
        "dlctus",
        "thesis",
    )


def test_published_forms_for_the_laptop():
    nsrd, dlctus = (composed("train", [f"experiment=laptop/{name}_published"]) for name in ("nsrd", "dlctus"))
    assert (nsrd.choices["loss"], nsrd.cfg.task.jitter, nsrd.choices["budget"]) == ("nsrd", "none", "laptop_nsrd")
    assert [nsrd.choices[f"model/{slot}"] for slot in ("locate", "base", "demodulate")] == ["none", "none", "lighting"]
    assert (dlctus.choices["loss"], dlctus.choices["model/confine"], dlctus.choices["budget"]) == (
        "l1",
        "clamp",
        "laptop",
    )
    assert len(nsrd.cfg.scene) == len(dlctus.cfg.scene) == 9


def rows_of(page, header):
    """The cells of a page's table, without backquotes."""
    lines = (CONF.parent / "docs" / page).read_text().splitlines()
    first = lines.index(header) + 2
    table = itertools.takewhile(lambda line: line.startswith("|"), lines[first:])
    return [[cell.strip().replace("`", "") for cell in line.strip("|").split("|")] for line in table]


def test_the_page_has_the_recipes():
    """Every model once, and in each row what its command composes to."""
    rows = rows_of("train.md", "| model | `loss` | `task` | `task.jitter` | `pick` | source |")
    assert sorted(model for row in rows for model in row[0].split(", ")) == sorted(MODELS)
    for models, loss, task, jitter, pick, _ in rows:
        for model in models.split(", "):
            chosen, cfg = choices(f"model={model}")
            assert (task, jitter) == (chosen[1], cfg.task.jitter)
            assert (loss, pick) in ((chosen[0], chosen[2]), ("", ""))
            assert bool(loss) == (
                model not in ("nearest", "bilinear", "bicubic", "jau", "jau_bicubic", "tus", "tus_thesis")
            )


def test_help_prints_the_recipes(command):
    """``train.py --help`` and ``count.py --help``: a line per model."""
    out = command("count", "--help").out
    lines = out[out.index("== Recipe of each model") : out.index("== Slots")].splitlines()[1:]
    assert {line.partition(":")[0] for line in lines if line} == set(MODELS)
    assert "nsrr_fast: loss=nsrr task=nsrr pick=uniform (task.jitter=none)" in lines
    assert "enss_l: loss=l1 task=qrisp pick=edges (task.jitter=halton16)" in lines
    assert "tus: none, it is not trained" in lines


def test_the_page_has_the_slots_with_their_models():
    """The table of switches names each slot's options, and the published one of each model that has the slot."""
    families = {"tus_thesis": "tus", "nsrr_fast": "nsrr", "enss_s": "enss", "enss_m": "enss", "enss_l": "enss"}
    rows = {row[0]: row[1:] for row in rows_of("train.md", "| slot | options | default by model |")}
    slots = {
        (families.get(model, model), slot): option
        for model in MODELS
        for slot, option in published_stages(model).items()
    }
    assert {f"model/{slot}" for _, slot in slots} == set(rows)
    for slot, (options, defaults) in rows.items():
        assert all(re.search(rf"\b{option}\b", options) for option in stems(slot))
        expected = {model: option for (model, name), option in slots.items() if f"model/{name}" == slot}
        written = {
            m: o
            for part in defaults.split(";")
            for ms, _, o in [part.partition(":")]
            for m in ms.replace(" ", "").split(",")
        }
        assert {model: option.strip() for model, option in written.items()} == expected


def test_a_model_without_a_recipe_is_told_where_it_belongs(command, tmp_path):
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "mine.yaml").write_text("_target_: supersampling.models.jau.JAU\nscale: 4\n")
    answer = command("train", "--config-dir", str(tmp_path), "model=mine", "--cfg", "job")
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "Model mine has no recipe: write conf/recipe/mine.yaml" in answer.err
    assert command("train", "--config-dir", str(tmp_path), "model=mine", "recipe=none", "--cfg", "job").status == 0


def test_a_search_s_answer_keeps_its_recipe():
    """The file of an answer is composed by train.py, whose model would bring its paper's task."""
    from hydra import initialize_config_dir

    from supersampling.advice.answer import experiment_file

    with initialize_config_dir(str(CONF), version_base="1.3"):
        text = experiment_file(["model=nsrd", "recipe=laptop", "budget=laptop_nsrd"], ["atrium"])
    assert "override /recipe: laptop" in text
