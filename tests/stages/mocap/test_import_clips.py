"""Folders, archives and manifests of motions become one artefact of clips and come back from it."""

from __future__ import annotations

import tarfile

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.motion.layouts import open_clips
from ipcli.io.motion.quaternions import matrices
from ipcli.params import Run, resolve
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.mocap import import_clips
from ipcli.stages.mocap.parameters import ImportClips

JOINTS, PARENTS = ("hips", "head", "foot"), (-1, 0, 0)


def save(path, seed=0, frames=13, scale=1.0, **extra):
    path.parent.mkdir(parents=True, exist_ok=True)
    positions = scale * np.random.default_rng(seed).uniform(-1, 1, (frames, 3, 3))
    np.savez(path, **{"positions": positions, "joints": JOINTS, "parents": PARENTS, "rate": 120.0, **extra})
    return positions


def made(source, output, **flags):
    params = resolve(ImportClips, env={}, flags=flags)
    return import_clips.run(source, output, params, Run())


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "set"
    for seed, name in enumerate(("wave/ann/a", "wave/bob/b", "kick/ann/a")):
        save(place / f"{name}.npz", seed)
    return place


def test_folders_are_labels_and_actors(folder, tmp_path):
    assert made(folder, tmp_path / "x.clips.h5", rate=30.0) is Outcome.DONE
    clips = open_clips(tmp_path / "x.clips.h5")
    assert clips.labels == ("kick", "wave", "wave")
    assert clips.actors == ("ann", "ann", "bob")
    assert len(set(clips.names)) == 3
    assert clips.skeleton.joints == JOINTS
    assert clips.skeleton.parents == PARENTS
    clip = clips.load(clips.names[2])
    whole = np.load(folder / "wave/bob/b.npz")["positions"]
    np.testing.assert_array_equal(clip.motion.positions, whole[::4].astype(np.float32))
    assert clip.motion.rate == 30
    assert (clip.label, clip.actor) == ("wave", "bob")
    assert made(folder, tmp_path / "x.clips.h5", rate=30.0) is Outcome.UP_TO_DATE


def test_an_archive_is_its_folder_and_the_same_source_gives_the_same_bytes(folder, tmp_path):
    with tarfile.open(tmp_path / "set.tar.xz", "w:xz") as tar:
        tar.add(folder, arcname="anything")
    made(tmp_path / "set.tar.xz", tmp_path / "a.h5")
    made(tmp_path / "set.tar.xz", tmp_path / "b.h5")
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    made(folder, tmp_path / "c.h5")
    one, other = open_clips(tmp_path / "a.h5"), open_clips(tmp_path / "c.h5")
    for name, twin in zip(one.names, other.names, strict=True):
        np.testing.assert_array_equal(one.load(name).motion.positions, other.load(twin).motion.positions)


def test_a_manifest_says_what_is_what(folder, tmp_path):
    (folder / "manifest.csv").write_text(
        "path,label,actor,start,stop,split\r\nwave/ann/a.npz,w,1,2,5,train\r\nwave/ann/a.npz,v,1,5,,test\r\nkick/ann/a.npz,,,,,\r\n"
    )
    made(folder, tmp_path / "x.h5")
    clips = open_clips(tmp_path / "x.h5")
    assert clips.labels == ("w", "v", "")
    assert clips.actors == ("1", "1", "")
    np.testing.assert_array_equal(clips.splits["published"], [1, 2, 0])
    whole = np.load(folder / "wave/ann/a.npz")["positions"].astype(np.float32)
    np.testing.assert_array_equal(clips.load(clips.names[0]).motion.positions, whole[2:5])
    np.testing.assert_array_equal(clips.load(clips.names[1]).motion.positions, whole[5:])


@pytest.mark.parametrize(
    ("manifest", "message"),
    [
        ("label,actor\nx,y\n", "manifest.csv: wrong columns"),
        ("path,label\nwave/ann/b.npz,x\n", "manifest.csv: line 2: no file 'wave/ann/b.npz'"),
        ("path,start\nwave/ann/a.npz,-1\n", "manifest.csv: line 2: '-1' is not a frame"),
        ("path,start,stop\nwave/ann/a.npz,20,30\n", "no frames between start and stop"),
        ("path,split\nwave/ann/a.npz,dev\n", "line 2: split 'dev'"),
        ("path\nmanifest.csv\n", "csv"),
        ("path\n", "no motion in it"),
    ],
)
def test_broken_manifests(folder, tmp_path, manifest, message):
    (folder / "manifest.csv").write_text(manifest)
    with pytest.raises(FormatError, match=message):
        made(folder, tmp_path / "x.h5")


def test_rotations_and_frames_that_were_not_seen_come_through(tmp_path):
    quaternions = np.random.default_rng(8).normal(size=(13, 3, 4))
    rotations = matrices(quaternions)
    rotations[3, 1] = np.nan
    positions = np.random.default_rng(9).uniform(-1, 1, (13, 3, 3))
    positions[4, 2] = np.nan
    save(tmp_path / "s" / "a.npz", positions=positions, rotations=rotations)
    made(tmp_path / "s", tmp_path / "x.h5")
    motion = open_clips(tmp_path / "x.h5").load("a").motion
    np.testing.assert_allclose(motion.rotations, rotations, atol=1e-6)
    np.testing.assert_allclose(motion.positions, positions, atol=1e-6)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_the_world_is_turned_upright_and_stays_right_handed(tmp_path, up):
    tall = np.zeros((2, 3, 3))
    tall[:, 1, "xyz".index(up)] = 1.8
    tall[:, 2] = np.roll([0.3, 0, 0], "xyz".index(up) - 1)
    save(tmp_path / "s" / "a.npz", positions=tall, rotations=np.broadcast_to(np.eye(3), (2, 3, 3, 3)))
    made(tmp_path / "s", tmp_path / "x.h5", **{"source.up": up})
    motion = open_clips(tmp_path / "x.h5").load("a").motion
    np.testing.assert_allclose(motion.positions[0, 1], [0, 1.8, 0], atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(motion.rotations), 1, atol=1e-6)


def test_what_cannot_be_is_refused(folder, tmp_path):
    with pytest.raises(ParameterError, match="no action 'wve' among the 2 there are; did you mean 'wave'"):
        made(folder, tmp_path / "x.h5", labels="wve")
    with pytest.raises(ParameterError, match="lies in the source"):
        made(folder, folder / "x.h5")
    save(folder / "wave/ann/c.npz", joints=("b0", "b1", "b2"))
    with pytest.raises(FormatError, match="c: another skeleton than that of 'kick"):
        made(folder, tmp_path / "x.h5")
    save(tmp_path / "mm" / "a.npz", scale=1000.0)
    with pytest.raises(FormatError, match="a.npz: a body of this size is no person's .*--unit"):
        made(tmp_path / "mm", tmp_path / "x.h5")
    (tmp_path / "rest").mkdir()
    (tmp_path / "rest" / "a.asf").write_text(":root")
    with pytest.raises(FormatError, match="no motion in it .*ASF file is a skeleton at rest"):
        made(tmp_path / "rest", tmp_path / "x.h5")
    (tmp_path / "bad.tar.xz").write_bytes(b"no archive")
    with pytest.raises(FormatError, match="bad.tar.xz: not a readable archive"):
        made(tmp_path / "bad.tar.xz", tmp_path / "x.h5")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FormatError, match="no known layout of clips"):
        open_clips(tmp_path / "empty")


@pytest.mark.real
@pytest.mark.parametrize(
    ("name", "clips", "frames", "actions", "splits"),
    [("florence3d", 215, 4016, 9, 10), ("utkinect/utkinect.tar.xz", 199, 5829, 10, 10)],
)
def test_kinect_sets_have_the_published_counts_upright_people_and_actors_on_one_side_of_a_split(
    real_data, name, clips, frames, actions, splits
):
    found = open_clips(real_data("mocap") / name)
    motions = [found.load(clip).motion for clip in found.names]
    assert (len(found.names), sum(len(m.positions) for m in motions), len(set(found.labels))) == (
        clips,
        frames,
        actions,
    )
    assert len(set(found.actors)) == 10
    assert len(found.splits) == splits
    head, foot = (found.skeleton.joints.index(joint) for joint in ("head", "left_ankle"))
    assert np.median([np.median(m.positions[:, head, 1] - m.positions[:, foot, 1]) for m in motions]) > 1.0
    left, right = (found.skeleton.joints.index(f"{side}_shoulder") for side in ("left", "right"))
    across = [np.median(m.positions[:, right, 0] - m.positions[:, left, 0]) for m in motions]
    assert np.mean(np.array(across) > 0) > 0.9  # they face the sensor, which looks along z: left is at smaller x
    for row in found.splits.values():
        sides = {
            actor: {int(s) for a, s in zip(found.actors, row, strict=True) if a == actor} for actor in found.actors
        }
        assert all(len(side) == 1 for side in sides.values())
        assert set(row) == {1, 2}


def test_actions_get_other_names_and_are_joined(folder, tmp_path):
    made(folder, tmp_path / "x.clips.h5", rename="wave=greet, kick=greet")
    assert set(open_clips(tmp_path / "x.clips.h5").labels) == {"greet"}
    made(folder, tmp_path / "y.clips.h5", rename="wave=bye bye")
    assert sorted(set(open_clips(tmp_path / "y.clips.h5").labels)) == ["bye bye", "kick"]


@pytest.mark.parametrize(
    ("rename", "said"), [("wave", "--rename wave: expected OLD=NEW"), ("wav=x", "no action 'wav'.*did you mean 'wave'")]
)
def test_a_name_that_is_not_there_or_no_pair_is_wrong_usage(folder, tmp_path, rename, said):
    with pytest.raises(ParameterError, match=said):
        made(folder, tmp_path / "x.clips.h5", rename=rename)
