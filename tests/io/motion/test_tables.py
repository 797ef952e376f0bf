"""NPZ and CSV tables read back what was written; broken ones are explained."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.geometry import lie
from ipcli.io.motion import tables

JOINTS = ("hips", "head", "left.foot")
PARENTS = (-1, 0, 0)


@pytest.fixture
def positions():
    values = np.random.default_rng(1).normal(size=(4, 3, 3)).round(4)
    values[2, 1] = np.nan
    return values


def save_csv(folder, positions, times=(0, 0.04, 0.08, 0.12), skeleton=True):
    header = ",".join(["time", *(f"{joint}.{axis}" for joint in JOINTS for axis in "xyz")])
    rows = [
        ",".join([f"{time}", *("" if np.isnan(value) else f"{value}" for value in frame.ravel())])
        for time, frame in zip(times, positions, strict=False)
    ]
    (folder / "a.csv").write_text("\r\n".join([header, *rows, ""]))
    if skeleton:
        (folder / "skeleton.csv").write_text("joint,parent\nhips,\nhead,hips\nleft.foot,hips\n")
    return folder / "a.csv"


def test_csv_reads_back(tmp_path, positions):
    motion = tables.read_csv(save_csv(tmp_path, positions))
    np.testing.assert_array_equal(motion.positions, positions)
    assert (motion.skeleton.joints, motion.skeleton.parents, motion.rate) == (JOINTS, PARENTS, 25.0)


def test_csv_without_a_skeleton_is_loose_joints(tmp_path, positions):
    assert tables.read_csv(save_csv(tmp_path, positions, skeleton=False)).skeleton.parents == (-1, -1, -1)


def test_npz_reads_back_with_rotations_in_either_form(tmp_path, positions):
    rotations = lie.exp(np.random.default_rng(2).normal(size=(4, 3, 3)))
    half = np.linalg.norm(lie.log(rotations), axis=-1, keepdims=True) / 2
    quaternions = np.concatenate([lie.log(rotations) / (2 * half) * np.sin(half), np.cos(half)], axis=-1)
    for stored in (rotations, quaternions):
        np.savez(
            tmp_path / "a.npz", positions=100 * positions, joints=JOINTS, parents=PARENTS, rate=25, rotations=stored
        )
        motion = tables.read_npz(tmp_path / "a.npz", unit=0.01)
        np.testing.assert_allclose(motion.positions, positions)
        np.testing.assert_allclose(motion.rotations, rotations, atol=1e-14)
        assert (motion.skeleton.joints, motion.skeleton.parents, motion.rate) == (JOINTS, PARENTS, 25.0)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("hips.y", "hips.z", "line 1: not the header of a motion"),
        ("time,", "", "line 2: 10 cells .expected 9"),
        ("0.08", "0.09", "line 4: times are uneven .expected steps of 0.04"),
        ("0.08,", "0.08,x", "line 4: could not convert string to float"),
        ("0.12,", "0.12,1,", "line 5: 11 cells .expected 10"),
        ("0.12,", "0.12,inf", "line 5: could not convert"),
    ],
)
def test_broken_csv(tmp_path, positions, before, after, message):
    path = save_csv(tmp_path, positions)
    path.write_text(path.read_text().replace(before, after, 1))
    with pytest.raises(FormatError, match=f"a.csv: {message}"):
        tables.read_csv(path)


def test_csv_without_times_needs_a_rate(tmp_path, positions):
    path = save_csv(tmp_path, positions[:1])
    with pytest.raises(FormatError, match="no frame rate .*--source-rate"):
        tables.read_csv(path)
    assert tables.read_csv(path, rate=10).rate == 10


def test_a_skeleton_of_other_joints(tmp_path, positions):
    path = save_csv(tmp_path, positions)
    (tmp_path / "skeleton.csv").write_text("joint,parent\nhips,\nhead,hip\n")
    with pytest.raises(FormatError, match="skeleton.csv: line 3: no joint 'hip'"):
        tables.read_csv(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": None}, "no array 'positions'"),
        ({"joints": None}, "no array 'joints'"),
        ({"rate": None}, "no frame rate"),
        ({"rate": 0}, "no frame rate"),
        ({"positions": np.zeros((4, 2, 3))}, r"positions have the wrong shape .expected .frames, 3, 3., got .4, 2, 3."),
        ({"positions": np.zeros((0, 3, 3))}, "no frames"),
        ({"positions": np.full((4, 3, 3), np.nan)}, "no joint is known in any frame"),
        ({"positions": np.full((4, 3, 3), np.inf)}, "an infinite position at frame 0, joint 'hips'"),
        ({"positions": np.array("x")}, "positions holds no numbers"),
        ({"parents": (1, 2, 0)}, "joint 'hips' hangs from no root"),
        ({"parents": (-1, 0, 3)}, "parents do not fit the joints"),
        ({"joints": ("a", "b", "a")}, "two joints are named 'a'"),
        ({"rotations": np.zeros((4, 3, 3, 3))}, "a matrix that is no rotation at frame 0, joint 'hips'"),
        ({"rotations": np.zeros((4, 3, 3))}, "rotations have the wrong shape"),
    ],
    ids=lambda value: value if isinstance(value, str) else next(iter(value)),
)
def test_broken_npz(tmp_path, change, message):
    arrays = {"positions": np.ones((4, 3, 3)), "joints": JOINTS, "parents": PARENTS, "rate": 25} | change
    np.savez(tmp_path / "a.npz", **{key: value for key, value in arrays.items() if value is not None})
    with pytest.raises(FormatError, match=message):
        tables.read_npz(tmp_path / "a.npz")


def test_npz_that_is_none(tmp_path):
    for content in (b"", b"PK\x03\x04 but no more", b"text"):
        (tmp_path / "a.npz").write_bytes(content)
        with pytest.raises(FormatError, match="not a readable NPZ file"):
            tables.read_npz(tmp_path / "a.npz")
