"""The Parquet table of scores: written tables are read back, and invalid tables are errors of one sentence."""

import numpy as np
import pandas as pd
import pytest

from supersampling.errors import UserError
from supersampling.metrics.scores import Scores, read_scores, write_scores


def frames() -> pd.DataFrame:
    rows = [
        (s, c, f, 20.0 + c + f, np.nan if f == 0 else 0.1 * f)
        for s in ("atrium", "stk/x")
        for c in (0, 1)
        for f in range(3)
    ]
    table = pd.DataFrame(rows, columns=["scene", "clip", "frame", "psnr", "temporal"])
    table.loc[0, "psnr"] = np.inf
    return table


def scores() -> Scores:
    clips = frames().groupby(["scene", "clip"])[["psnr", "temporal"]].mean().reset_index()
    return Scores.with_scene_means(frames(), clips.assign(vmaf=[70.0, 80.0, 90.0, 50.0]))


def test_frames_clips_and_scenes_are_read_back(tmp_path):
    write_scores(tmp_path / "frames.parquet", scores())
    read = read_scores(tmp_path / "frames.parquet")
    pd.testing.assert_frame_equal(read.frames, frames(), check_dtype=False)
    assert read.clips["vmaf"].tolist() == [70, 80, 90, 50]
    assert read.scenes["vmaf"].tolist() == [75, 70]
    assert list(read.frames.columns) == ["scene", "clip", "frame", "psnr", "temporal"]  # vmaf has no value of a frame
    assert np.isinf(read.frames["psnr"][0])
    assert np.isnan(read.frames["temporal"][0])


def test_another_program_reads_it(tmp_path):
    write_scores(tmp_path / "frames.parquet", scores())
    rows = pd.read_parquet(tmp_path / "frames.parquet")
    assert len(rows) == 12 + 4 + 2
    clip = rows[(rows["scene"] == "stk/x") & (rows["clip"] == 1) & rows["frame"].isna()]
    assert clip["psnr"].tolist() == [22.0]
    assert rows[rows["clip"].isna()]["scene"].tolist() == ["atrium", "stk/x"]


def change(**columns: object) -> pd.DataFrame:
    return pd.DataFrame({"scene": ["a", "a"], "clip": [0, 0], "frame": [0, None], "psnr": [1.0, 1.0], **columns})


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (change().drop(columns="clip"), "with scene, clip, frame and"),
        (change().drop(columns="psnr"), "at least one metric"),
        (change(psnr=["high", "low"]), "Column psnr"),
        (change(scene=[1, 2]), "Column scene"),
        (change(frame=[0.5, 1.5]), "Column frame"),
        (change(frame=pd.array([0, 0], "Int32")), "Two rows .* the same place .*frame 0"),
        (change(frame=pd.array([0, 1], "Int32")), "frames of clip 0 of a but no row"),
        (change(clip=pd.array([None, 0], "Int32"), frame=pd.array([0, None], "Int32")), "has a frame but no clip"),
    ],
)
def test_invalid_tables_are_errors(tmp_path, table, message):
    if table.get("frame") is not None and table["frame"].tolist()[:1] == [0.0]:
        table = table.astype({"frame": "Int32"})
    table.to_parquet(tmp_path / "wrong.parquet")
    with pytest.raises(UserError, match=message):
        read_scores(tmp_path / "wrong.parquet")


def test_other_file_formats_are_errors(tmp_path):
    (tmp_path / "x.parquet").write_text("not parquet")
    with pytest.raises(UserError, match="not a Parquet table"):
        read_scores(tmp_path / "x.parquet")
