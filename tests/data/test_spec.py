"""The name and the JSON of a specification: a changed jitter pattern is other data, everything else keeps its name."""

import json
from dataclasses import replace

import pytest

from supersampling.data.spec import CaptureSpec

SPEC = CaptureSpec(
    scene="atrium",
    split="val",
    clips=1,
    frames=4,
    targets=4,
    frame=(1920, 1080),
    window=(64, 64),
    scale=4,
    jitter="thesis",
    mip_bias="matched",
    samples=2,
    seed=0,
    candidates=2,
)
# Names of files that were rendered before patterns had revisions.
FORMER = {
    ("thesis", 4): "atrium_val_x4_c1373d93.h5",
    ("thesis", 2): "atrium_val_x2_481e2f0b.h5",
    ("thesis", 3): "atrium_val_x3_0fa97f05.h5",
    ("halton16", 4): "atrium_val_x4_518ffe4e.h5",
    ("none", 4): "atrium_val_x4_8abf990e.h5",
}


@pytest.mark.parametrize(("jitter", "scale"), FORMER)
def test_only_the_changed_patterns_have_new_names(jitter, scale):
    spec = replace(SPEC, jitter=jitter, scale=scale)
    changed = jitter == "thesis" and scale in (2, 4)
    assert (spec.file_name != FORMER[jitter, scale]) == changed
    assert spec.jitter_revision == int(changed)


@pytest.mark.parametrize(("jitter", "scale"), FORMER)
def test_former_file_is_read_as_what_it_is(jitter, scale):
    """Its specification has no revision: it keeps its JSON, so its fingerprint, and is not equal to today's."""
    today = replace(SPEC, jitter=jitter, scale=scale)
    values = json.loads(today.to_json())
    values.pop("jitter_revision", None)
    text = json.dumps(values, sort_keys=True)
    former = CaptureSpec.from_json(text)
    assert former.to_json() == text
    assert former.file_name == FORMER[jitter, scale]
    assert (former == today) == (former.file_name == today.file_name)


def test_json_restores_the_specification():
    for spec in (SPEC, replace(SPEC, jitter="none"), replace(SPEC, scale=3)):
        assert CaptureSpec.from_json(spec.to_json()) == spec
    with pytest.raises(ValueError, match="jitter_revision=one"):
        CaptureSpec.from_json(json.dumps({**json.loads(SPEC.to_json()), "jitter_revision": "one"}))
