"""Clips of several sources become motions of one skeleton at one rate, or it is said why not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.skeleton import Skeleton
from ipcli.stages.mocap import reading
from ipcli.stages.mocap.parameters import ClipReading
from tests.fixtures.mocap_bodies import GROUPS, SKELETON
from tests.fixtures.mocap_clips import clip, every, write, write_groups


@pytest.fixture
def source(tmp_path):
    return write(tmp_path / "a.clips.h5", every(frames=12, repeats=1))


def test_all_clips_come_at_the_rate_asked_for(source):
    known = reading.read([source], ClipReading(rate=15.0), GROUPS)
    assert (known.rates == 15).all()
    assert (known.lengths == 6).all()
    assert {*known.splits} == {"first", "second"}


def test_the_splits_of_several_sources_are_left_behind(source, tmp_path):
    other = write(tmp_path / "b.clips.h5", [replace(clip("kick", 1), name="another")])
    known = reading.read([source, other], ClipReading(), GROUPS)
    assert [one.name for one in known.clips][-1] == "another"
    assert len(known.clips) == 13
    assert not known.splits


def test_a_clip_that_is_there_twice_is_refused(source):
    with pytest.raises(FormatError, match="there twice"):
        reading.read([source, source], ClipReading(), GROUPS)


@pytest.mark.parametrize(
    ("skeleton", "message"),
    [
        (Skeleton(tuple("nose" if name == "head" else name for name in SKELETON.joints), SKELETON.parents), "nose"),
        (Skeleton(SKELETON.joints, (-1, 0, 1, 1, *SKELETON.parents[4:])), "bones between others"),
    ],
)
def test_another_skeleton_is_refused_and_said_in_what(source, skeleton, message):
    with pytest.raises(FormatError, match=message):
        reading.read([source], ClipReading(), GROUPS, skeleton)


def test_a_body_without_height_names_its_clip(tmp_path):
    flat = clip("kick", 0)
    flat = replace(flat, motion=replace(flat.motion, positions=np.zeros_like(flat.motion.positions), rotations=None))
    source = write(tmp_path / "flat.clips.h5", [flat])
    with pytest.raises(ParameterError, match=f"clip '{flat.name}'"):
        reading.read([source], ClipReading(), GROUPS)


def test_a_file_of_groups_is_an_input_and_a_name_is_none(tmp_path):
    groups = write_groups(tmp_path / "groups.toml")
    assert reading.inputs([Path("a")], str(groups)) == (Path("a"), tmp_path / "groups.toml")
    assert reading.inputs([Path("a")], "auto") == (Path("a"),)
