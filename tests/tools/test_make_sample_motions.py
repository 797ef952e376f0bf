"""The generated people: the same bytes again, rigid bones of three builds, and each action does what its name says."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from ipcli.geometry.motion import body_height, bone_lengths, heading
from ipcli.io.motion import groups
from ipcli.io.motion.layouts import open_clips

ROOT = Path(__file__).parents[2]
MOTIONS = ROOT / "sample_data" / "motions"


@pytest.fixture(scope="module")
def maker():
    spec = importlib.util.spec_from_file_location("make_sample_motions", ROOT / "tools" / "make_sample_motions.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def clips():
    return open_clips(MOTIONS)


@pytest.fixture(scope="module")
def loaded(clips):
    """Motions by action, in the frame in which the body faces +z at the start."""
    parts = groups.find("auto", clips.skeleton)
    found = {}
    for name, label in zip(clips.names, clips.labels, strict=True):
        motion = clips.load(name).motion
        found.setdefault(label, []).append(motion.positions @ heading(motion.skeleton, motion.positions, parts)[0])
    return found


def test_the_files_come_out_again_byte_for_byte(maker):
    paths = sorted(MOTIONS.rglob("*.bvh"))
    assert len(paths) == len(maker.ACTIONS) * len(maker.ACTORS) * maker.TAKES
    for path in paths:
        action, actor, number = path.relative_to(MOTIONS).with_suffix("").parts
        assert path.read_text(encoding="utf-8") == maker.take(action, actor, int(number)), path


def test_the_sample_is_small_and_labelled(clips):
    assert sum(path.stat().st_size for path in MOTIONS.rglob("*")) < 1e6
    assert sorted(set(clips.labels)) == ["kick", "squat", "walk", "wave"]
    assert sorted(set(clips.actors)) == [
        "ann",
        "bob",
        "eve",
    ]


def test_people_differ_in_build_and_keep_their_bones(clips):
    parts, heights = groups.find("bvh", clips.skeleton), {}
    for name, actor in zip(clips.names, clips.actors, strict=True):
        motion = clips.load(name).motion
        bones = motion.skeleton.bones()
        lengths = np.linalg.norm(motion.positions[:, bones[:, 1]] - motion.positions[:, bones[:, 0]], axis=-1)
        assert np.abs(lengths - bone_lengths(motion.skeleton, motion.positions)[bones[:, 1]]).max() < 1e-12
        heights.setdefault(actor, set()).add(round(body_height(motion.skeleton, motion.positions, parts), 9))
    assert all(len(own) == 1 for own in heights.values())
    assert len(set().union(*heights.values())) == 3
    assert all(1.3 < height < 1.8 for own in heights.values() for height in own)


def test_each_action_does_what_its_name_says(clips, loaded):
    at = {joint: clips.skeleton.joints.index(joint) for joint in clips.skeleton.joints}
    for walked in loaded["walk"]:
        assert walked[-1, at["Hips"], 2] - walked[0, at["Hips"], 2] > 0.9  # metres forward
        assert np.ptp(walked[:, at["LeftFoot"], 2] - walked[:, at["RightFoot"], 2]) > 0.5
    for kicked in loaded["kick"]:
        reach = kicked[:, at["RightFoot"], 2] - kicked[:, at["Hips"], 2]
        assert reach.max() > 0.5
        assert np.ptp(kicked[:, at["LeftFoot"], 1]) < 0.15
        assert kicked[reach.argmax(), at["RightFoot"], 1] > kicked[0, at["RightFoot"], 1] + 0.3
    for sat in loaded["squat"]:
        assert np.ptp(sat[:, at["Hips"], 1]) > 0.3
        assert np.ptp(sat[:, at["LeftFoot"], 1]) < 0.15
    for waved in loaded["wave"]:
        over = waved[:, at["RightHand"], 1] - waved[:, at["Head"], 1]
        assert np.mean(over > 0) > 0.4
        assert (waved[:, at["LeftHand"], 1] < waved[:, at["Hips"], 1] + 0.2).all()
    for motions in loaded.values():
        for motion in motions:
            assert motion[:, at["Head"], 1].min() > 0.6
            assert motion[..., 1].min() > -0.15
