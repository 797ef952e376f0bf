"""Doubts about clips: none about sound ones, and the option that mends each kind of fault."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.mocap import checks
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import clip, every

TURNS = {"z": np.roll(np.eye(3), 1, axis=0), "-y": np.diag([1.0, -1.0, -1.0])}


def moved(one, matrix):
    return replace(one, motion=replace(one.motion, positions=one.motion.positions @ matrix, rotations=None))


def stand_up(axis):
    """The matrix from the right that makes `axis` what y was."""
    return np.roll(np.eye(3), 1, axis=1) if axis == "z" else TURNS[axis]


@pytest.mark.parametrize("groups", [GROUPS, None])
def test_sound_clips_raise_no_doubt(groups):
    assert checks.doubts(every(frames=6, repeats=1), groups) == []


@pytest.mark.parametrize("groups", [GROUPS, None])
@pytest.mark.parametrize("axis", TURNS)
def test_bodies_along_another_axis_name_the_option(groups, axis):
    clips = [moved(one, stand_up(axis)) for one in every(frames=6, repeats=1)]
    (doubt,) = checks.doubts(clips, groups)
    assert f"give --up {axis}" in doubt


def test_mixed_axes_name_the_odd_ones():
    clips = every(frames=6, repeats=1)
    clips[1] = moved(clips[1], stand_up("z"))
    (doubt,) = checks.doubts(clips, GROUPS)
    assert clips[1].name in doubt
    assert "different up axes" in doubt


@pytest.mark.parametrize(("size", "is_odd"), [(0.35, True), (0.8, False), (4.0, True)])
def test_bodies_of_an_odd_size_name_the_unit(size, is_odd):
    clips = [moved(one, size * np.eye(3)) for one in every(frames=6, repeats=1)]
    assert ["--unit" in doubt for doubt in checks.doubts(clips, GROUPS)] == [True] * is_odd


def test_notes_of_one_kind_are_told_once():
    clips = [replace(one, motion=replace(one.motion, notes=("odd",))) for one in every(frames=2, repeats=1)[:5]]
    (line,) = checks.notes([*clips, clip("kick", 0, 2)])
    assert line == f"{', '.join(one.name for one in clips[:3])} and 2 more: odd"
