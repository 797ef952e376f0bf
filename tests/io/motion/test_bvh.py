"""BVH against kinematics by hand: all orders of angles, position channels anywhere, end sites; and broken files."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import FormatError, IpcliError
from ipcli.io.motion import bvh
from tests.fixtures.errors import check_message

ORDERS = [*map("".join, itertools.permutations("XYZ"))]
HEAD = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Leg
  {
    OFFSET 0 -10 0
    CHANNELS 3 Yrotation Xrotation Zrotation
    End Site
    {
      OFFSET 0 -5 1
    }
  }
}
"""
FILE = HEAD + "MOTION\nFrames: 2\nFrame Time: 0.0333333\n0 100 0 0 0 0 0 0 0\n1 2 3 30 40 50 60 70 80\n"


@pytest.fixture
def written(tmp_path):
    def write(text=FILE, newline="\n", name="a.bvh"):
        (tmp_path / name).write_text(text, encoding="latin-1", newline=newline)
        return tmp_path / name

    return write


def turn(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    flat = {
        "X": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "Y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "Z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(flat[axis])


def test_a_file_against_kinematics_by_hand(written):
    motion = bvh.read(written())
    assert motion.skeleton.joints == ("Hips", "Leg", "Leg_end")
    assert motion.skeleton.parents == (-1, 0, 1)
    np.testing.assert_allclose(motion.positions[0], [[0, 1, 0], [0, 0.9, 0], [0, 0.85, 0.01]], atol=1e-15)
    hips = turn("Z", 30) @ turn("X", 40) @ turn("Y", 50)
    leg = hips @ turn("Y", 60) @ turn("X", 70) @ turn("Z", 80)
    start = np.array([0.01, 0.02, 0.03])
    knee = start + hips @ [0, -0.1, 0]
    np.testing.assert_allclose(motion.positions[1], [start, knee, knee + leg @ [0, -0.05, 0.01]], atol=1e-15)
    np.testing.assert_allclose(motion.rotations[1], [hips, leg, leg], atol=1e-15)
    assert motion.rate == pytest.approx(30, abs=1e-3)


@pytest.mark.parametrize("root", ORDERS)
@pytest.mark.parametrize("leg", [*ORDERS, "X", "ZY"])
def test_any_order_of_angles_in_any_joint(written, root, leg):
    text = FILE.replace(
        "Zrotation Xrotation Yrotation\n  JOINT", " ".join(f"{axis}rotation" for axis in root) + "\n  JOINT"
    )
    text = text.replace(
        "CHANNELS 3 Yrotation Xrotation Zrotation",
        f"CHANNELS {len(leg)} " + " ".join(f"{axis}rotation" for axis in leg),
    )
    text = text.replace(
        "0 100 0 0 0 0 0 0 0\n1 2 3 30 40 50 60 70 80",
        "0 " * (6 + len(leg)) + "\n1 2 3 30 40 50 " + "60 70 80"[: 3 * len(leg)],
    )
    motion = bvh.read(written(text))
    hips = np.linalg.multi_dot([turn(axis, angle) for axis, angle in zip(root, (30, 40, 50), strict=True)])
    own = np.eye(3)
    for axis, angle in zip(leg, (60, 70, 80), strict=False):
        own = own @ turn(axis, angle)
    np.testing.assert_allclose(motion.rotations[1, :2], [hips, hips @ own], atol=1e-14)


def test_position_channels_anywhere_replace_the_offset_axis_by_axis(written):
    text = FILE.replace(
        "CHANNELS 3 Yrotation Xrotation Zrotation", "CHANNELS 4 Yrotation Zposition Xrotation Zrotation"
    )
    text = text.replace("0 100 0 0 0 0 0 0 0", "0 100 0 0 0 0 0 7 0 0").replace("60 70 80", "60 8 70 80")
    motion, expected = bvh.read(written(text)), bvh.read(written(name="b.bvh"))
    np.testing.assert_allclose(motion.positions[0, 1], [0, 0.9, 0.07], atol=1e-15)
    np.testing.assert_allclose(motion.rotations, expected.rotations, atol=1e-15)
    hips = expected.rotations[1, 0]
    np.testing.assert_allclose(motion.positions[1, 1] - motion.positions[1, 0], hips @ [0, -0.1, 0.08], atol=1e-15)


def test_a_root_without_position_channels_stands_at_its_offset(written):
    text = FILE.replace("OFFSET 0 0 0", "OFFSET 1 2 3").replace(
        "CHANNELS 6 Xposition Yposition Zposition", "CHANNELS 3"
    )
    text = text.replace("0 100 0 0 0 0 0 0 0", "0 0 0 0 0 0").replace("1 2 3 30", "30")
    np.testing.assert_allclose(bvh.read(written(text)).positions[:, 0], [[0.01, 0.02, 0.03]] * 2, atol=1e-15)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_case_namespaces_and_wrapped_frames_do_not_matter(written, newline):
    expected = bvh.read(written())
    text = (
        FILE.replace("ROOT Hips", "ROOT mixamorig:Hips")
        .replace("Zrotation", "ZROTATION")
        .replace("1 2 3 30", "1 2 3\n30")
    )
    text = text.replace("Frames: 2", "Frames:\t2  ").replace("# f\xfcr", "")
    np.testing.assert_array_equal(bvh.read(written(text, newline)).positions, expected.positions)
    assert bvh.read(written(text)).skeleton == expected.skeleton


def test_unit_and_rate_can_be_told_and_unknown_values_stay_unknown(written):
    motion = bvh.read(
        written(FILE.replace("1 2 3 30", "nan 2 3 30").replace("60 70 80", "nan 70 80")), unit=0.0254, rate=25
    )
    assert motion.rate == 25
    assert motion.positions[0, 0, 1] == pytest.approx(2.54)
    assert np.isnan(motion.positions[1, :, 0]).all()
    assert np.isnan(motion.rotations[1, 1:]).all()
    assert np.isfinite(motion.rotations[1, 0]).all()


BROKEN = [
    ("HIERARCHY", "HIRARCHY", "line 1: 'HIRARCHY' .expected HIERARCHY"),
    ("ROOT Hips\n{", "ROOT Hips\n", "line 4: 'OFFSET' .expected {"),
    ("OFFSET 0 -10 0", "OFFSET 0 -10", "line 9: 'CHANNELS' .expected three numbers after OFFSET"),
    ("    OFFSET 0 -10 0\n", "", "line 6: joint 'Leg' has no OFFSET"),
    ("CHANNELS 3", "CHANNELS 4", "line 10: channel 'End'; did you mean"),
    ("CHANNELS 3", "CHANNELS 7", "line 9: '7' .expected 0 to 6 channels"),
    ("Yrotation Xrotation Zrotation", "Yrotation Xrotation Yrotation", "line 9: channel 'Yrotation'"),
    (
        "Yrotation Xrotation Zrotation",
        "Yrotation Xrotation Zrotatoin",
        "line 9: channel 'Zrotatoin'; did you mean 'Zrotation'",
    ),
    ("  }\n}\n", "  }\n", "line 15: 'MOTION' .expected } of joint 'Hips'"),
    ("JOINT Leg", "ROOT Leg", "line 6: 'ROOT Leg' .expected ROOT outermost"),
    ("Frames: 2", "Frames: 3", "wrong number of values .expected 3 frames of 9 numbers, got 18 numbers"),
    ("Frames: 2", "Frames: 0", "line 17: '0' .expected at least one frame"),
    ("0.0333333", "0", "line 18: '0' .expected a frame time"),
    ("60 70 80", "60 70 8o", "line 20: '8o' is not a number"),
    (" 80\n", "\n", "wrong number of values .expected 2 frames of 9 numbers, got 17"),
    (FILE[FILE.index("MOTION") :], "", "line 15: the file ends .expected MOTION"),
    (FILE, "", "line 1: the file ends .expected HIERARCHY"),
]


@pytest.mark.parametrize(("before", "after", "message"), BROKEN, ids=[case[2][:40] for case in BROKEN])
def test_what_is_broken_is_said_with_its_line(written, before, after, message):
    assert before in FILE
    with pytest.raises(FormatError, match=f"a.bvh: {message}"):
        bvh.read(written(FILE.replace(before, after, 1)))


@given(st.integers(0, len(FILE)), st.text("0123456789.-:{} \nabrxyz", max_size=6), st.booleans())
def test_damage_anywhere_is_a_one_line_error_or_a_sound_motion(tmp_path_factory, at, dirt, cut):
    path = tmp_path_factory.mktemp("bvh") / "a.bvh"
    path.write_text(FILE[:at] + dirt + ("" if cut else FILE[at + len(dirt) :]))
    try:
        motion = bvh.read(path)
    except IpcliError as error:
        check_message(error, path)
    else:
        assert motion.positions.shape == (*motion.rotations.shape[:2], 3)


DIALECT = """HIERARCHY
ROOT {root}
{{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT {joint}
  {{
    OFFSET 0 50 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    {end}
    {{
      OFFSET 0 40 0
    }}
  }}
}}
MOTION
Frames: 2
{time}
{first}
0 91 0 0 0 0 0 0 90
"""
USUAL = {
    "root": "Hips",
    "joint": "Spine",
    "end": "End Site",
    "time": "Frame Time: 0.04",
    "first": "0 90 0 0 0 0 0 -90 0",
}


def dialect(tmp_path, encoding="utf-8", tail="", **changes):
    path = tmp_path / "a.bvh"
    path.write_bytes((DIALECT.format(**USUAL | changes) + tail).encode(encoding))
    return bvh.read(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"encoding": "utf-8-sig"},
        {"encoding": "utf-16"},
        {"tail": "\x1a"},
        {"tail": "\r\n\x1a\r\n"},
        {"end": "End Site Toe"},
        {"end": "End Site\tLeft Toe"},
        {"time": "Frame\tTime:\t0.04"},
        {"time": "Frame  Time:  0.04"},
        {"time": "FRAME TIME:0.04"},
        {"first": "0 90 0 0 0 0 0-90 0"},
    ],
    ids=str,
)
def test_dialects_mean_the_same(tmp_path, changes):
    plain, other = dialect(tmp_path), dialect(tmp_path, **changes)
    assert other.skeleton == plain.skeleton
    assert other.rate == plain.rate == 25
    np.testing.assert_array_equal(other.positions, plain.positions)
    assert bool(other.notes) == ("first" in changes)


@pytest.mark.parametrize("name", ["Bip01 L Calf", "左足", "jambe_à_gauche", "Épine 1"])
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_names_are_read_as_they_were_written(tmp_path, name, encoding):
    if encoding == "latin-1" and not name.isascii() and max(name) > "ÿ":
        pytest.skip("Latin-1 has no such letters")
    assert dialect(tmp_path, encoding, joint=name).skeleton.joints == ("Hips", name, f"{name}_end")


def test_frames_a_second_in_place_of_the_time_of_a_frame_are_named_as_the_cause(tmp_path):
    with pytest.raises(FormatError, match="expected 1 to 1000 Hz.*frames a second stand.*--source-rate 30"):
        dialect(tmp_path, time="Frame Time: 30")


def test_a_word_among_the_numbers_is_named_with_its_line(tmp_path):
    with pytest.raises(FormatError, match="line 19: '9O' is not a number"):
        dialect(tmp_path, first="0 9O 0 0 0 0 0 0 0")


def test_a_last_number_that_may_be_cut_is_said(tmp_path):
    (note,) = dialect(tmp_path, tail="").notes or ("",)
    assert not note
    path = tmp_path / "b.bvh"
    path.write_text(DIALECT.format(**USUAL).rstrip("\n"))
    assert bvh.read(path).notes == (bvh.CUT,)
