"""NPZ and CSV tables read back what was written; broken ones are explained."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.geometry import lie
from ipcli.geometry.skeleton import Skeleton
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


def write_times(tmp_path, times, first="time"):
    rows = [f"{time},0.1,1,0,0,{1.7 + n / 100},0" for n, time in enumerate(times)]
    path = tmp_path / "t.csv"
    path.write_text("\n".join([f"{first},hips.x,hips.y,hips.z,head.x,head.y,head.z", *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("rate", "places"), [(30, 3), (120, 3), (60, 3), (25, 3), (29.5, 4), (30, 2)])
def test_times_that_were_rounded_are_even(tmp_path, rate, places):
    path = write_times(tmp_path, [f"{n / rate:.{places}f}" for n in range(24)])
    assert tables.read_csv(path).rate == pytest.approx(rate, rel=1e-4)


@pytest.mark.parametrize("lost", [1, 11])
def test_a_dropped_frame_is_no_rounding(tmp_path, lost):
    path = write_times(tmp_path, [f"{n / 30:.3f}" for n in range(24) if n != lost])
    with pytest.raises(FormatError, match=f"line {lost + 2}: times are uneven"):
        tables.read_csv(path)


def test_milliseconds_are_named_as_the_cause(tmp_path):
    with pytest.raises(FormatError, match="expected 1 to 1000 Hz.*milliseconds, give --source-rate 30"):
        tables.read_csv(write_times(tmp_path, [f"{1000 * n / 30:.4f}" for n in range(6)]))


@pytest.mark.parametrize("dialect", ["bom", "semicolon", "tab", "case"])
def test_dialects_of_tables_mean_the_same(tmp_path, dialect):
    path = write_times(tmp_path, ["0.00", "0.04", "0.08"])
    plain, text = tables.read_csv(path), path.read_text()
    header, _, rows = text.partition("\n")
    text = {
        "bom": "\ufeff" + text,
        "semicolon": text.replace(",", ";").replace(".", ",").replace("hips,", "hips.").replace("head,", "head."),
        "tab": text.replace(",", "\t"),
        "case": header.replace("time", "Time").replace(".x", ".X") + "\n" + rows,
    }[dialect]
    path.write_text(text, encoding="utf-8")
    other = tables.read_csv(path)
    assert (other.skeleton, other.rate) == (plain.skeleton, plain.rate)
    np.testing.assert_array_equal(other.positions, plain.positions)


def test_frame_numbers_that_are_left_out_are_frames_of_nan(tmp_path):
    motion = tables.read_csv(write_times(tmp_path, [5, 6, 9], "frame"), rate=30)
    assert len(motion.positions) == 5
    np.testing.assert_array_equal(np.isnan(motion.positions).all(axis=(1, 2)), [False, False, True, True, False])


@pytest.mark.parametrize("frames", [(1, 3, 2), (1, 1, 2), (1, 2, "")])
def test_frame_numbers_that_do_not_grow_are_refused(tmp_path, frames):
    with pytest.raises(FormatError, match="line 4: frame numbers do not grow|line 3: frame numbers do not grow"):
        tables.read_csv(write_times(tmp_path, frames, "frame"), rate=30)


def test_frame_numbers_far_apart_ask_for_no_memory(tmp_path):
    with pytest.raises(FormatError, match="odd gaps"):
        tables.read_csv(write_times(tmp_path, [1, 2, 10**9], "frame"), rate=30)


def test_a_joint_at_exactly_0_0_0_was_not_seen():
    standing = np.array([[[0, 1.0, 0], [0, 1.7, 0], [0.1, 0.1, 0]]] * 4)
    standing[1:3, 1] = 0
    found, notes = tables.unseen(standing, Skeleton(("hips", "head", "foot"), (-1, -1, -1)))
    assert np.isnan(found[1:3, 1]).all()
    assert np.isnan(found).sum() == 6
    assert notes == ("'head' is at exactly 0 0 0 in 2 of 4 frames: not seen",)


@pytest.mark.parametrize("parents", [(-1, -1, -1), (-1, 0, 0)])
def test_the_origin_that_a_body_was_moved_to_is_seen(parents):
    centred = np.array(
        [[[0, 0.0, 0], [0, 0.7, 0.1], [0.1, -0.9, -0.1]], [[0, 0.0, 0], [0.1, 0.7, -0.1], [-0.1, -0.9, 0.1]]]
    )
    found, notes = tables.unseen(centred, Skeleton(("hips", "head", "foot"), parents))
    np.testing.assert_array_equal(found, centred)
    assert not notes


def test_names_that_were_pickled_are_named_with_the_cure(tmp_path):
    joints = np.array(["a", "b"], dtype=object)
    np.savez(tmp_path / "a.npz", positions=np.ones((2, 2, 3)), joints=joints, rate=30.0)
    with pytest.raises(FormatError, match="joints is an array of Python objects.*dtype=str"):
        tables.read_npz(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "odd",
    [{"rate": [30.0, 30.0]}, {"rate": "x"}, {"parents": [np.nan, 0]}, {"parents": [-1, 1e300]}, {"positions": 1.0}],
    ids=str,
)
def test_odd_arrays_are_refused(tmp_path, odd):
    sound = {"positions": np.ones((2, 2, 3)), "joints": ["a", "b"], "rate": 30.0, "parents": [-1, 0]}
    np.savez(tmp_path / "a.npz", **sound | odd)
    with pytest.raises(FormatError, match="a.npz"):
        tables.read_npz(tmp_path / "a.npz")
