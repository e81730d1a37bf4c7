"""The papers' tables and figures made of pictures: a list of them, and our runs' pictures side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from supersampling.reporting.figures.carried import over_time_gallery, state_gallery
from supersampling.reporting.figures.side_by_side import crop_row, epipolar_row, most_different, read_scenes
from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, Section
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.reporting.papers.pictures import PictureRuns
from supersampling.reporting.papers.published import name_of
from supersampling.reporting.papers.schema import Paper, full_stop

# The artifact folders that a kind of picture needs.
FOLDERS = {
    "crops": ["crops"],
    "error_maps": ["crops"],
    "epipolar": ["epipolar"],
    "accumulation": ["state", "crops"],
    "reweighting": ["state", "crops"],
    "blending": ["state", "crops"],
    "mask_over_time": ["steps"],
}
DIFFERENT = (
    "At most three scenes, those where the images differ most; the marked detail, magnified below, is where they "
    "differ most, not where one is best."
)
WORST = (
    "At most three scenes, those with the largest error; the marked detail, magnified below, is where it is largest."
)
FULL_WIDTH = 7  # pictures
NOTES = {
    "crops": "",
    "error_maps": "Then the absolute error, black for none.",
    "epipolar": "The middle row of pixels in every frame, time downwards, at the columns where the images differ most.",
    "accumulation": "After a clip’s last frame: white is 1, black 0.",
    "reweighting": (
        "In a clip’s last frame, for 1 and more frames back: black is weight 0, white the largest, 10 in the paper; "
        "weight 1 is a tenth."
    ),
    "blending": "In a clip’s last frame. Mask: white takes the candidate, black keeps the reprojected output.",
    "mask_over_time": (
        "The last frames of a clip: black keeps the reprojected output, white takes the new candidate; dots are the "
        "samples. The window is the one of the crop that keeps most of its history."
    ),
}


@dataclass(frozen=True)
class Drawn:
    """Items of a paper with the same runs, and their gallery; None with the reason if there is nothing to draw."""

    items: list[PictureRuns]
    gallery: Gallery | None
    labels: list[str]
    reason: str = ""

    @property
    def text(self) -> str:
        """Return what the list of pictures says of ours."""
        item = self.items[0]
        if item.picture.counterpart == "none":
            return "not drawn"
        sweep = f" (sweeps={item.picture.sweep})" if item.picture.sweep else ""
        missing = f"not run: {', '.join(item.missing)}{sweep}" if item.missing else ""
        if self.gallery is None:
            return "; ".join(part for part in (missing, self.reason) if part)
        parts = [f"below: {', '.join(self.labels)}", missing, self.reason]
        return "; ".join(part for part in parts if part)


def section(report: Report) -> Section | None:
    """Return a paper's pictures with ours; None for the overview, and for a paper without any."""
    if report.subject is None or not report.subject.pictures:
        return None
    paper = report.subject.paper
    drawn = [_draw(group, index, report) for index, group in enumerate(_groups(report.subject.pictures))]
    sheet = picture_sheet(drawn, report.subject.pictures, paper)
    export([sheet], report.stem)
    galleries = [
        replace(item.gallery, caption=_caption(item, paper), share=_share(item.gallery))
        for item in drawn
        if item.gallery is not None
    ]
    return Section(title="Pictures", sheets=[sheet], galleries=galleries)


def _groups(items: Sequence[PictureRuns]) -> list[list[PictureRuns]]:
    """Return the items, those that show the same pictures of the same runs together."""
    groups: dict[object, list[PictureRuns]] = {}
    for index, item in enumerate(items):
        runs = tuple((label, tuple(run.id for run in runs)) for label, runs in item.runs.items())
        picture = item.picture
        key = (picture.counterpart, runs, tuple(picture.scenes)) if item.present else index
        groups.setdefault(key, []).append(item)
    return list(groups.values())


def _draw(group: list[PictureRuns], index: int, report: Report) -> Drawn:
    item = group[0]
    kind = item.picture.counterpart
    if kind == "none" or not item.present:
        return Drawn(group, None, [])
    folders = {name: report.material.first_folders(item.present, name) for name in FOLDERS[kind]}
    labels = [label for label in item.present if all(label in by_label for by_label in folders.values())]
    absent = [label for label in item.present if label not in labels]
    reason = f"without {FOLDERS[kind][0]}/, so score again: {', '.join(absent)}" if absent else ""
    usable = {name: {label: by_label[label] for label in labels} for name, by_label in folders.items()}
    gallery = _gallery(item, usable, report.folder, f"picture{index}") if labels else None
    if gallery is not None and not gallery.rows:
        scenes = " or ".join(item.picture.scenes)
        reason = reason or (f"no pictures of {scenes}" if scenes else "no scene has pictures of all")
        gallery = None
    return Drawn(group, gallery, labels, reason)


def _gallery(item: PictureRuns, folders: Mapping[str, Mapping[str, Path]], out: Path, prefix: str) -> Gallery:
    kind = item.picture.counterpart
    if kind == "mask_over_time":
        return over_time_gallery(folders["steps"], out, prefix)
    if kind not in ("crops", "error_maps", "epipolar"):
        return state_gallery(kind, folders["state"], folders["crops"], out, prefix)
    scenes = most_different(read_scenes(folders[FOLDERS[kind][0]], item.picture.scenes, kind != "epipolar"))
    rows = [
        epipolar_row(scene, out, prefix) if kind == "epipolar" else crop_row(scene, out, prefix, kind == "error_maps")
        for scene in scenes
    ]
    return Gallery([shot.head for shot in scenes[0].shots] if scenes else [], rows, [])


def _caption(drawn: Drawn, paper: Paper) -> list[Text]:
    names = [name_of(item.picture.number) for item in drawn.items]
    joined = " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
    titles = " ".join(full_stop(item.picture.title) for item in drawn.items)
    item = drawn.items[0]
    words = [titles, f"Ours: {item.setting}."]
    if item.picture.counterpart in ("crops", "error_maps"):
        words.append(DIFFERENT if len(drawn.labels) > 1 else WORST)
    words.append(NOTES[item.picture.counterpart])
    if item.missing:
        words.append(f"Not run: {', '.join(item.missing)}.")
    return [Text(full_stop(f"After {joined} {paper.of}") + " ", "bold"), Text(" ".join(word for word in words if word))]


def _share(gallery: Gallery) -> float:
    """Return the part of the text's width at which a few pictures are not larger than they would be among many."""
    return 1.0 if len(gallery.heads) == 1 else min(1.0, (len(gallery.heads) + 0.25) / FULL_WIDTH)


def picture_sheet(drawn: Sequence[Drawn], items: Sequence[PictureRuns], paper: Paper) -> Sheet:
    """Return the list of a paper's pictures and what is drawn of ours, or which runs are missing."""
    texts = {id(item): group.text for group in drawn for item in group.items}
    rows = [
        [
            Text(name_of(item.picture.number)),
            Text(item.picture.section),
            Text(" ".join(full_stop(text) for text in (item.picture.title, item.picture.note) if text)),
            Text(texts[id(item)], "plain" if texts[id(item)].startswith("below") else "muted"),
        ]
        for item in items
    ]
    heads = ["where", "section", "what", "ours"]
    return Sheet(name="pictures", title=full_stop(f"Pictures {paper.of}"), headers=heads, rows=rows, labels=4)
