"""Generated recordings in the published layouts of Florence 3D Actions and of UTKinect-Action."""

from __future__ import annotations

import gc
import tarfile

import numpy as np
import pytest
import scipy.io

from ipcli.errors import FormatError
from ipcli.io.motion.kinect import FLORENCE, KINECT, is_florence, is_utkinect, open_florence, open_utkinect
from tests.fixtures.errors import check_message

ACTIONS = ("wave", "drink", "bow")
CLIPS = ((1, 2, 4), (3, 1, 1), (2, 1, 6))  # action, subject, frames
LABELS = "s01_e01\nwalk: 2 8\nsitDown: 8 12 \ns02_e01\nwalk: 0 4\npull: NaN NaN\n"


def cells(items):
    array = np.empty((1, len(items)), object)
    array[0] = items
    return array


def save_splits(path):
    """The first split learns of subject 1, the second of 2; subject 3 is in neither."""
    train, test = np.array([[1.0], [2.0]]), np.array([[2.0], [1.0]])
    scipy.io.savemat(path, {"tr_subjects": train, "te_subjects": test})


def write_florence(folder):
    rng = np.random.default_rng(0)
    places = [rng.normal(size=(3, 15, frames)) for _, _, frames in CLIPS]
    recordings = [
        {"action": float(action), "subject": float(subject), "original_skeletal_data": place}
        for (action, subject, _), place in zip(CLIPS, places, strict=True)
    ]
    folder.mkdir(parents=True, exist_ok=True)
    scipy.io.savemat(folder / "skeletal_data.mat", {"skeletal_data": cells(recordings)})
    scipy.io.savemat(folder / "action_names.mat", {"action_names": cells(list(ACTIONS))})
    save_splits(folder / "tr_te_splits.mat")
    return places


def write_utkinect(folder, numbers=range(0, 20, 2)):
    """Two takes of rows at every second frame number, coordinates drawn."""
    joints = folder / "set" / "joints"
    joints.mkdir(parents=True)
    (joints / "actionLabel.txt").write_text(LABELS)
    tables = {}
    for seed, take in enumerate(("s01_e01", "s02_e01")):
        rows = np.random.default_rng(seed).normal(size=(len(numbers), 60)).round(6)
        tables[take] = dict(zip(numbers, rows.reshape(-1, 20, 3), strict=True))
        np.savetxt(joints / f"joints_{take}.txt", np.c_[list(numbers), rows], fmt="%.6f")
    save_splits(folder / "set" / "tr_te_splits.mat")
    return tables


def mirror_free(upright, sensor):
    """Whether the triple products of the first four joints have changed their sign: the sensor's axes are
    left-handed.
    """
    return np.allclose(np.linalg.det(upright), -np.linalg.det(sensor))


def test_florence_says_who_does_what_and_has_y_up(tmp_path):
    places = write_florence(tmp_path)
    assert is_florence(tmp_path)
    assert not is_utkinect(tmp_path)
    clips = open_florence(tmp_path)
    assert (clips.names, clips.labels, clips.actors) == (
        ("001", "002", "003"),
        ("wave", "bow", "drink"),
        ("02", "01", "01"),
    )
    assert {name: row.tolist() for name, row in clips.splits.items()} == {"01": [2, 1, 1], "02": [1, 2, 2]}
    for name, place in zip(clips.names, places, strict=True):
        one = clips.load(name)
        assert (one.label, one.actor) == (clips.labels[int(name) - 1], clips.actors[int(name) - 1])
        assert (one.motion.rate, one.motion.skeleton, one.motion.rotations) == (30.0, FLORENCE, None)
        x, depth, up = place
        np.testing.assert_array_equal(one.motion.positions, np.stack([x.T, up.T, depth.T], axis=-1))
        bones = [np.diff(p, axis=1)[:, :3] for p in (one.motion.positions, np.moveaxis(place, -1, 0).swapaxes(1, 2))]
        assert mirror_free(*bones)


def test_a_lost_joint_is_at_exactly_zero_and_is_not_known(tmp_path):
    places = write_florence(tmp_path)
    places[0][:, 4, 2] = 0
    places[0][1:, 5, 3] = 0  # two coordinates at 0 are a place
    recordings = [{"action": 1.0, "subject": 1.0, "original_skeletal_data": places[0]}]
    scipy.io.savemat(tmp_path / "skeletal_data.mat", {"skeletal_data": cells(recordings)})
    unknown = np.isnan(open_florence(tmp_path).load("001").motion.positions)
    assert unknown[2, 4].all()
    assert unknown.sum() == 3


def test_utkinect_is_cut_by_frame_numbers(tmp_path):
    tables = write_utkinect(tmp_path)
    assert is_utkinect(tmp_path)
    assert not is_florence(tmp_path)
    clips = open_utkinect(tmp_path)
    assert clips.names == ("s01_e01_walk", "s01_e01_sitDown", "s02_e01_walk")
    assert (clips.labels, clips.actors) == (("walk", "sitDown", "walk"), ("01", "01", "02"))
    assert {name: row.tolist() for name, row in clips.splits.items()} == {"01": [1, 1, 2], "02": [2, 2, 1]}
    for name, take, numbers in (
        ("s01_e01_walk", "s01_e01", (2, 4, 6, 8)),
        ("s01_e01_sitDown", "s01_e01", (8, 10, 12)),
        ("s02_e01_walk", "s02_e01", (0, 2, 4)),
    ):
        one = clips.load(name)
        np.testing.assert_array_equal(one.motion.positions, [tables[take][number] for number in numbers])
        assert one.motion.rate == 15.0  # every second frame of 30 a second
        assert one.motion.skeleton == KINECT


def test_rows_of_a_frame_that_was_there_before_are_left_out(tmp_path):
    tables = write_utkinect(tmp_path)
    path = tmp_path / "set" / "joints" / "joints_s01_e01.txt"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], lines[2].replace("-", " "), *lines[3:]]) + "\n")
    found = open_utkinect(tmp_path).load("s01_e01_walk").motion.positions
    np.testing.assert_array_equal(found, [tables["s01_e01"][number] for number in (2, 4, 6, 8)])


def test_corrected_labels_go_before_the_published_ones(tmp_path):
    write_utkinect(tmp_path)
    (tmp_path / "set" / "joints" / "actionLabel_modified.txt").write_text("s02_e01\nbow: 0 6\n")
    assert open_utkinect(tmp_path).names == ("s02_e01_bow",)


@pytest.mark.parametrize(
    ("write", "opened"),
    [(write_florence, open_florence), (write_utkinect, open_utkinect)],
    ids=["florence", "utkinect"],
)
def test_an_archive_is_its_folder_as_long_as_its_clips_are_held(tmp_path, write, opened):
    write(tmp_path / "in")
    path = tmp_path / "a.tar.xz"
    with tarfile.open(path, "w:xz") as tar:
        tar.add(tmp_path / "in", "deep/er")
    clips, twin = opened(path), opened(tmp_path / "in")
    gc.collect()
    assert (clips.names, clips.labels, clips.actors) == (twin.names, twin.labels, twin.actors)
    assert clips.files(clips.names[0]) == (path,)
    assert list(clips.splits) == ["01", "02"]
    for name in clips.names:
        np.testing.assert_array_equal(clips.load(name).motion.positions, twin.load(name).motion.positions)


def test_without_the_file_of_splits_there_are_none(tmp_path):
    write_florence(tmp_path)
    (tmp_path / "tr_te_splits.mat").unlink()
    assert open_florence(tmp_path).splits == {}


def test_every_bone_of_the_sensor_hangs_together():
    for skeleton in (FLORENCE, KINECT):
        assert len(skeleton.bones()) == len(skeleton.joints) - 1
        sides = {joint: joint.replace("left", "right") for joint in skeleton.joints if "left" in joint}
        for left, right in sides.items():
            chains = [
                [skeleton.joints[joint] for joint in skeleton.path(skeleton.joints.index(name))]
                for name in (left, right)
            ]
            assert [name.replace("left", "right") for name in chains[0]] == chains[1]


def refused(call, *mentioned):
    with pytest.raises(FormatError) as raised:
        call()
    check_message(raised.value, *mentioned)


@pytest.mark.parametrize("name", ["skeletal_data.mat", "action_names.mat", "tr_te_splits.mat"])
def test_a_damaged_file_of_florence_is_named(tmp_path, name):
    write_florence(tmp_path)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    refused(lambda: open_florence(tmp_path), name)
    scipy.io.savemat(tmp_path / name, {"skeletal_dota": 1})
    refused(lambda: open_florence(tmp_path), f"{name}: no variable", "did you mean 'skeletal_dota'?")


def test_names_of_actions_that_are_not_there_are_asked_for(tmp_path):
    write_florence(tmp_path)
    (tmp_path / "action_names.mat").unlink()
    refused(lambda: open_florence(tmp_path), "action_names.mat: no such file")


def test_a_clip_of_florence_of_another_shape_is_refused_when_it_is_read(tmp_path):
    write_florence(tmp_path)
    recordings = [{"action": 1.0, "subject": 1.0, "original_skeletal_data": np.ones((3, 20, 5))}]
    scipy.io.savemat(tmp_path / "skeletal_data.mat", {"skeletal_data": cells(recordings)})
    refused(lambda: open_florence(tmp_path).load("001"), "clip 001 has the wrong shape", "(3, 15, frames)")


@pytest.mark.parametrize(
    ("labels", "mentioned"),
    [
        ("walk: 1 2\n", "line 1: 'walk: 1 2'"),
        ("s01_e01\nwalk: 1\n", "line 2: 'walk: 1'"),
        ("s01_e01\nwalk: 1 b\n", "line 2"),
        ("s01_e01\nwalk: -1 5\n", "line 2"),
    ],
)
def test_labels_that_cut_nothing_are_refused_and_the_line_named(tmp_path, labels, mentioned):
    write_utkinect(tmp_path)
    (tmp_path / "set" / "joints" / "actionLabel.txt").write_text(labels)
    refused(lambda: open_utkinect(tmp_path), "actionLabel.txt", mentioned)


def test_a_table_without_the_frames_or_with_other_columns_is_refused(tmp_path):
    write_utkinect(tmp_path)
    joints = tmp_path / "set" / "joints"
    (joints / "actionLabel.txt").write_text("s01_e01\nwalk: 100 200\n")
    refused(lambda: open_utkinect(tmp_path).load("s01_e01_walk"), "no frame of s01_e01_walk", "frames 100 to 200")
    np.savetxt(joints / "joints_s01_e01.txt", np.ones((3, 46)))
    refused(lambda: open_utkinect(tmp_path).load("s01_e01_walk"), "rows of the wrong length", "got 46")
    (joints / "joints_s01_e01.txt").write_text("1 2 x\n")
    refused(lambda: open_utkinect(tmp_path).load("s01_e01_walk"), "joints_s01_e01.txt: not a table of numbers")
