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


@pytest.mark.parametrize("dialect", ["bom", "semicolon", "case", "backslash"])
def test_dialects_of_manifests_mean_the_same(tmp_path, dialect):
    save(tmp_path / "in" / "a.npz")
    text = "path,label,actor\nin/a.npz,wave,ann\n"
    change = {
        "bom": "\ufeff" + text,
        "semicolon": text.replace(",", ";"),
        "case": text.replace("path,label,actor", "Path,LABEL,Actor"),
        "backslash": text.replace("/", "\\"),
    }
    (tmp_path / "manifest.csv").write_text(change[dialect], encoding="utf-8")
    clips = open_recordings(tmp_path)
    assert (clips.names, clips.labels, clips.actors) == (("a",), ("wave",), ("ann",))


def test_a_stop_beyond_the_end_is_said(tmp_path):
    save(tmp_path / "a.npz")
    clips = open_recordings(manifest(tmp_path, "path,label,start,stop", "a.npz,wave,1,100"))
    motion = clips.load("a_1").motion
    assert len(motion.positions) == 9
    assert "stop 100 of the manifest lies beyond its 10 frames" in motion.notes[-1]


@pytest.mark.parametrize("text", ["²", "-1", "9" * 5000, "1.5"])
def test_what_is_no_number_of_a_frame_is_refused(tmp_path, text):
    save(tmp_path / "a.npz")
    with pytest.raises(FormatError, match="line 2: .* is not a frame"):
        open_recordings(manifest(tmp_path, "path,start", f"a.npz,{text}"))


@pytest.mark.parametrize("name", ["a\0b.npz", "a" * 5000])
def test_a_name_that_no_file_can_have_is_not_there(tmp_path, name):
    save(tmp_path / "a.npz")
    with pytest.raises(FormatError, match="line 2: no file"):
        open_recordings(manifest(tmp_path, "path", name))


def labelled(folder, actor=True):
    for label in ("wave", "kick"):
        save(folder / label / ("ann" if actor else "") / f"{label}.npz")


def test_a_set_in_one_folder_more_than_it_needs_is_found_there(tmp_path):
    labelled(tmp_path / "motions")
    clips = open_recordings(tmp_path)
    assert {*zip(clips.labels, clips.actors, strict=True)} == {("wave", "ann"), ("kick", "ann")}
    assert "everything lies in 'motions'" in clips.notes[-1]


def test_so_is_a_manifest(tmp_path):
    save(tmp_path / "motions" / "a.npz")
    manifest(tmp_path / "motions", "path,label", "a.npz,wave")
    assert open_recordings(tmp_path).labels == ("wave",)


def test_one_folder_that_may_be_a_label_or_not_is_said(tmp_path):
    labelled(tmp_path / "motions", actor=False)
    clips = open_recordings(tmp_path)
    assert {*clips.labels} == {"motions"}
    assert "all clips lie in 'motions'" in clips.notes[0]
    assert not open_recordings(tmp_path / "motions").notes


def test_files_of_a_kind_that_is_not_read_are_counted(tmp_path):
    labelled(tmp_path)
    (tmp_path / "wave" / "b.fbx").touch()
    assert open_recordings(tmp_path).notes == ("1 files of .fbx are not read: export them as BVH",)


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_any_axis_becomes_y(tmp_path, up):
    positions = np.random.default_rng(0).uniform(-1, 1, (4, 3, 3))
    positions[:, 1] = positions[:, 0]
    positions[:, 1, "xyz".index(up[-1])] += -1.5 if up[0] == "-" else 1.5
    np.savez(tmp_path / "a.npz", positions=positions, joints=JOINTS, parents=PARENTS, rate=60.0)
    turned = open_recordings(tmp_path, up=up).load("a").motion.positions
    np.testing.assert_allclose(turned[:, 1] - turned[:, 0], [[0, 1.5, 0]] * 4, atol=1e-12)
    triple = [np.linalg.det(p) for p in (positions[0], turned[0])]
    assert triple[0] == pytest.approx(triple[1])
