"""Motion files by manifest, names or folders: how they are called, cut, turned and scaled, and what is refused."""

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.motion.recordings import is_recordings, open_recordings
from ipcli.measurements.motions import TEST, TRAIN
from tests.fixtures.errors import check_message

JOINTS, PARENTS = ("hips", "head", "foot"), (-1, 0, 0)


def save(path, seed=0, frames=10, scale=1.0, joints=JOINTS):
    path.parent.mkdir(parents=True, exist_ok=True)
    positions = scale * np.random.default_rng(seed).uniform(-1, 1, (frames, 3, 3))
    np.savez(path, positions=positions, joints=joints, parents=PARENTS, rate=60.0)
    return positions


def manifest(folder, *lines):
    (folder / "manifest.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def test_folders_tell_split_label_and_actor(tmp_path):
    save(tmp_path / "train" / "wave" / "ann" / "a.npz")
    save(tmp_path / "test" / "kick" / "b.npz")
    clips = open_recordings(tmp_path)
    about = dict(zip(clips.names, zip(clips.labels, clips.actors, strict=True), strict=True))
    assert about == {"a": ("wave", "ann"), "b": ("kick", "")}
    (split,) = clips.splits.values()
    assert dict(zip(clips.names, split, strict=True)) == {"a": TRAIN, "b": TEST}


def test_names_of_hdm05_tell_label_and_actor_wherever_they_lie(tmp_path):
    save(tmp_path / "any" / "HDM_bd_squat1Reps_001_120.npz")
    clips = open_recordings(tmp_path)
    assert (clips.labels, clips.actors) == (("squat1Reps",), ("bd",))


def test_a_manifest_cuts_and_names(tmp_path):
    positions = save(tmp_path / "take.npz")
    rows = ("take.npz,wave,ann,0,4", "take.npz,kick,ann,4,10")
    clips = open_recordings(manifest(tmp_path, "path,label,actor,start,stop", *rows))
    assert clips.names == ("take_0", "take_4")
    second = clips.load("take_4")
    np.testing.assert_array_equal(second.motion.positions, positions[4:])
    assert (second.label, second.actor) == ("kick", "ann")


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path):
    for label in ("wave", "kick"):
        save(tmp_path / label / "a.npz")
    assert set(open_recordings(tmp_path).names) == {"wave.a", "kick.a"}


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("inch", 0.0254), ("0.5", 0.5), (None, 1.0)])
def test_lengths_come_in_metres(tmp_path, unit, metres):
    positions = save(tmp_path / "a.npz", scale=1 / metres)
    found = open_recordings(tmp_path, unit=unit).load("a").motion.positions
    np.testing.assert_allclose(found, positions * metres)


@pytest.mark.parametrize(("up", "axis"), [("x", 0), ("y", 1), ("z", 2)])
def test_the_axis_that_points_up_becomes_y_and_left_stays_left(tmp_path, up, axis):
    positions = save(tmp_path / "a.npz")
    found = open_recordings(tmp_path, up=up).load("a").motion.positions
    np.testing.assert_allclose(found[..., 1], positions[..., axis])
    # The volume that the three joints span keeps its sign: turned, not mirrored.
    np.testing.assert_allclose(np.linalg.det(found), np.linalg.det(positions), atol=1e-12)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (("label,actor", "wave,ann"), "wrong columns"),
        (("path,colour", "a.npz,red"), "wrong columns"),
        (("path", "b.npz"), "line 2: no file 'b.npz'"),
        (("path,split", "a.npz,learn"), "line 2: split 'learn'"),
        (("path,start", "a.npz,first"), "line 2: 'first' is not a frame"),
        (("path,start", "a.npz,-1"), "line 2: '-1' is not a frame"),
        (("path,name", "a.npz,x", "a.npz,x"), "two clips are named"),
        (("path",), "no motion in it"),
    ],
)
def test_a_wrong_manifest_is_refused_and_the_line_named(tmp_path, lines, message):
    save(tmp_path / "a.npz")
    with pytest.raises(FormatError) as raised:
        open_recordings(manifest(tmp_path, *lines))
    check_message(raised.value, message)


def test_a_cut_without_frames_is_refused(tmp_path):
    save(tmp_path / "a.npz")
    clips = open_recordings(manifest(tmp_path, "path,start,stop,name", "a.npz,0,5,first", "a.npz,50,60,late"))
    with pytest.raises(FormatError, match="no frames between start and stop"):
        clips.load("late")


def test_a_body_that_no_person_has_is_refused_with_the_option_that_mends_it(tmp_path):
    save(tmp_path / "a.npz", scale=1000)
    with pytest.raises(FormatError) as raised:
        open_recordings(tmp_path)
    check_message(raised.value, "--unit")


def test_a_file_of_another_skeleton_is_refused_when_it_is_read(tmp_path):
    save(tmp_path / "a.npz")
    save(tmp_path / "b.npz", joints=("hips", "nose", "foot"))
    clips = open_recordings(tmp_path)
    with pytest.raises(FormatError, match="another skeleton than a.npz"):
        clips.load("b")


@pytest.mark.parametrize("hints", [{"up": "w"}, {"unit": "mile"}, {"unit": "-1"}, {"unit": "nan"}])
def test_hints_that_mean_nothing_are_refused(tmp_path, hints):
    save(tmp_path / "a.npz")
    with pytest.raises(ParameterError, match=next(iter(hints))):
        open_recordings(tmp_path, **hints)


def test_what_is_no_motion_is_told_by_name(tmp_path):
    assert not is_recordings(tmp_path)
    (tmp_path / "manifest.csv").write_text("path\n", encoding="utf-8")
    (tmp_path / ".hidden.npz").write_bytes(b"")
    assert not is_recordings(tmp_path)
    save(tmp_path / "a.npz")
    assert is_recordings(tmp_path)
    assert is_recordings(tmp_path / "a.npz")
