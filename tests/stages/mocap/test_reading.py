"""Clips of several sources become motions of one skeleton at one rate, or it is said why not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.geometry.skeleton import Skeleton
from ipcli.models.mocap.parameters import Features
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


def renamed(one, names, parents=None):
    """The clip with other names of joints, or only with some of its joints, in another order."""
    motion, joints = one.motion, list(one.motion.skeleton.joints)
    chosen = [joints.index(name) for name in names]
    place = {old: new for new, old in enumerate(chosen)}
    own = tuple(place.get(motion.skeleton.parents[old], -1) for old in chosen)
    positions = motion.positions[:, chosen]
    return replace(
        one, motion=replace(motion, skeleton=Skeleton(tuple(names), own), positions=positions, rotations=None)
    )


def test_joints_are_found_by_their_names(tmp_path):
    one = clip("kick", 0)
    plain = replace(one, motion=replace(one.motion, rotations=None))
    shuffled = renamed(one, SKELETON.joints[::-1])
    paths = [write(tmp_path / f"{n}.h5", [each]) for n, each in enumerate((plain, shuffled))]
    first, second = (reading.read([path], ClipReading(), GROUPS, SKELETON).clips[0].motion for path in paths)
    assert second.skeleton == SKELETON
    np.testing.assert_array_equal(first.positions, second.positions)


def test_only_the_joints_of_the_groups_are_asked_for(tmp_path):
    needed = GROUPS.needed(SKELETON)
    some = replace(GROUPS, parts={"head": GROUPS.parts["head"]} if "head" in GROUPS.parts else GROUPS.parts)
    kept = [name for name in SKELETON.joints if name in some.needed(SKELETON)]
    path = write(tmp_path / "a.h5", [renamed(clip("kick", 0), kept)])
    known = reading.read([path], ClipReading(), some, SKELETON)
    lengths = known.reference_lengths()
    found = known.features(lengths, Features())
    assert all(np.isfinite(x).all() for x in found.values())
    without = [name for name in needed if name != GROUPS.top]
    path = write(tmp_path / "b.h5", [renamed(clip("kick", 0), without)])
    with pytest.raises(FormatError, match=f"another skeleton: it has no joint '{GROUPS.top}'.*did you mean"):
        reading.read([path], ClipReading(), GROUPS, SKELETON)


def test_what_is_odd_is_said(tmp_path, caplog):
    one = clip("kick", 0)
    lying = replace(one, motion=replace(one.motion, positions=one.motion.positions @ np.roll(np.eye(3), 1, axis=1)))
    reading.read([write(tmp_path / "a.h5", [one])], ClipReading(), GROUPS)
    assert not caplog.records
    reading.read([write(tmp_path / "b.h5", [lying])], ClipReading(), GROUPS)
    assert "--up" in caplog.text


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
