"""ASF/AMC against kinematics by hand, the conventions of the format one by one, and every way in which a file can be
broken.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import FormatError, IpcliError
from ipcli.geometry.motion import bone_lengths
from ipcli.io.motion import acclaim
from tests.fixtures.errors import check_message

ASF = """# made by hand
:version 1.10
:name test
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   written for the test
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 9
     axis 0 0 0 XYZ
     dof rx ry rz
     limits (-180 180)
  end
  begin
     id 2
     name fixed
     direction 1 0 0
     length 4.5
     axis 0 0 0 XYZ
  end
  begin
     id 3
     name shin
     direction 0 -1 0
     length 4.5
     axis 20 30 40 XYZ
     dof rx
  end
:hierarchy
  begin
    root thigh fixed
    thigh shin
  end
"""
AMC = """#!OML:ASF F:\\f\xfcr\\test.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 0 0 0 0 0 0
thigh 0 0 0
shin 0
2
root 0.45 0 0 0 90 0
thigh 90 0 0
shin 90
"""
SCALE = 0.0254 / 0.45


@pytest.fixture
def written(tmp_path):
    """Write test.asf and test_1.amc, changed as asked, and return the motion's path."""

    def write(asf=ASF, amc=AMC, name="test_1.amc", encoding="latin-1", newline="\n"):
        (tmp_path / "test.asf").write_text(asf, encoding=encoding, newline=newline)
        (tmp_path / name).write_text(amc, encoding=encoding, newline=newline)
        return tmp_path / name

    return write


def turn(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    flat = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(flat[axis])


def test_rest_pose_and_unit(written):
    motion = acclaim.read(written(), rate=120)
    assert motion.skeleton.joints == ("root", "thigh", "fixed", "shin")
    assert motion.skeleton.parents == (-1, 0, 0, 1)
    np.testing.assert_allclose(
        motion.positions[0], SCALE * np.array([[0, 0, 0], [0, -9, 0], [4.5, 0, 0], [0, -13.5, 0]]), atol=1e-15
    )
    np.testing.assert_allclose(motion.rotations[0], np.broadcast_to(np.eye(3), (4, 3, 3)), atol=1e-15)
    assert motion.rate == 120.0


def test_second_frame_against_kinematics_by_hand(written):
    motion = acclaim.read(written(), rate=120)
    root = turn("y", 90)
    thigh = root @ turn("x", 90)
    frame = turn("z", 40) @ turn("y", 30) @ turn("x", 20)  # angles turn about fixed axes in the order x, y, z
    shin = thigh @ frame @ turn("x", 90) @ frame.T
    for joint, expected in enumerate((root, thigh, root, shin)):
        np.testing.assert_allclose(motion.rotations[1, joint], expected, atol=1e-15)
    start = np.array([0.0254, 0, 0])
    knee = start + SCALE * 9 * thigh @ [0, -1, 0]
    expected = [start, knee, start + SCALE * 4.5 * root @ [1, 0, 0], knee + SCALE * 4.5 * shin @ [0, -1, 0]]
    np.testing.assert_allclose(motion.positions[1], expected, atol=1e-15)


@pytest.mark.parametrize("order", [*map("".join, itertools.permutations("xyz"))])
def test_angles_turn_about_fixed_axes_in_the_order_of_the_axis(written, order):
    asf = ASF.replace("axis 0 0 0 XYZ\n     dof rx ry rz", f"axis 0 0 0 {order.upper()}\n     dof rz rx ry")
    motion = acclaim.read(written(asf, AMC.replace("thigh 90 0 0", "thigh 30 10 20")), rate=120)
    angles = {"x": 10, "y": 20, "z": 30}  # channels come in the order of dof
    first, second, third = (turn(axis, angles[axis]) for axis in order)
    np.testing.assert_allclose(motion.rotations[1, 1], turn("y", 90) @ third @ second @ first, atol=1e-14)


def test_root_channels_come_in_any_order(written):
    asf = ASF.replace("order TX TY TZ RX RY RZ", "order RZ TY RY TX RX TZ")
    motion = acclaim.read(written(asf, AMC.replace("root 0.45 0 0 0 90 0", "root 0 0 90 0.45 0 0")), rate=120)
    expected = acclaim.read(written(), rate=120)
    np.testing.assert_array_equal(motion.positions, expected.positions)


def test_radians_by_the_motion_and_by_the_skeleton(written):
    expected = acclaim.read(written(), rate=120)
    radians = AMC.replace("90", repr(np.pi / 2))
    for asf, amc in (
        (ASF, radians.replace(":DEGREES", ":RADIANS")),
        (_radians(ASF), radians.replace(":DEGREES\n", "")),
    ):
        motion = acclaim.read(written(asf, amc), rate=120)
        np.testing.assert_allclose(motion.positions, expected.positions, atol=1e-12)


def _radians(asf: str) -> str:
    twenty, thirty, forty = np.deg2rad([20, 30, 40])
    return asf.replace("angle deg", "angle rad").replace("axis 20 30 40", f"axis {twenty!s} {thirty!s} {forty!s}")


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_suffix_and_encoding_do_not_matter(written, newline):
    expected = acclaim.read(written(), rate=120)
    path = written(name="TEST_2.AMC", newline=newline)
    np.testing.assert_array_equal(acclaim.read(path, rate=120).positions, expected.positions)


def test_the_rate_comes_from_the_option_the_file_or_the_name(written):
    stated = AMC.replace(":DEGREES", ":SAMPLES-PER-SECOND 60\n:DEGREES")
    assert acclaim.read(written(amc=stated)).rate == 60
    assert acclaim.read(written(amc=stated), rate=30).rate == 30
    path = written(name="HDM_test_x_001_120.amc")
    assert acclaim.read(path, acclaim.read_asf(path.parent / "test.asf")).rate == 120
    with pytest.raises(
        FormatError, match="test_1.amc: an AMC file that does not say its frame rate. Give it with --source-rate"
    ):
        acclaim.read(written())


def test_dropped_frames_are_unknown_frames(written):
    motion = acclaim.read(written(amc=AMC.replace("\n2\n", "\n4\n")), rate=120)
    assert np.isnan(motion.positions[1:3]).all()
    assert np.isnan(motion.rotations[1:3]).all()
    np.testing.assert_array_equal(motion.positions[[0, 3]], acclaim.read(written(), rate=120).positions)


def test_the_skeleton_is_the_longest_name_the_motion_begins_with(written, tmp_path):
    path = written(name="test_long_1.amc")
    (tmp_path / "test_long.asf").write_text(ASF)
    (tmp_path / "other.asf").write_text(ASF)
    assert acclaim.asf_of(path).name == "test_long.asf"


def test_translations_and_lengths_of_bones_move_them(written):
    asf = ASF.replace("dof rx\n", "dof rx ty l\n")
    amc = AMC.replace("shin 0\n", "shin 0 2 1\n").replace("shin 90\n", "shin 90 0 0\n")
    motion = acclaim.read(written(asf, amc), rate=120)
    np.testing.assert_allclose(motion.positions[0, 3], SCALE * np.array([0, -9 - 4.5 - 1 + 2, 0]), atol=1e-15)


BROKEN = [
    ("asf", ":hierarchy", ":hierarch", "no section :hierarchy"),
    ("asf", "thigh shin", "thigh shinn", "line 43: unknown bone 'shinn'; did you mean 'shin'[?] Describe"),
    ("asf", "root thigh fixed", "root thigh", "bone 'fixed' has no place under :hierarchy"),
    ("asf", "length 0.45", "length 0", "the unit of length is not above 0"),
    ("asf", "length 0.45", "length inch", "'inch' is not a number"),
    ("asf", "length 9", "length -9", "line 20: bone 'thigh' has a negative length"),
    ("asf", "direction 0 -1 0\n     length 9", "length 9", "line 16: a bone without its direction"),
    ("asf", "dof rx\n", "dof rw\n", "channel 'rw'"),
    ("asf", "axis 20 30 40 XYZ", "axis 20 30 40 XXZ", "axis order 'xxz'"),
    ("asf", "direction 1 0 0", "direction 1 0", "2 numbers .expected 3"),
    ("asf", "dof rx\n  end\n:hier", "dof rx\n:hier", "the bone that begins here does not end"),
    ("asf", "thigh shin\n", "thigh shin\n    shin thigh\n", "hangs from no root"),
    ("amc", "shin 90\n", "", "line 10: the file ends within a frame"),
    ("amc", "shin 90\n", "shin\n", "line 11: bone 'shin' .expected 1 values, got 0"),
    ("amc", "shin 90\n", "shin 9o\n", "line 11: '9o' is not a number"),
    ("amc", "shin 90\n", "foot 90\n", "line 11: 'foot' comes where shin has to"),
    ("amc", "thigh 90 0 0", "thigh 90 0", "line 10: bone 'thigh' .expected 3 values, got 2"),
    ("amc", "thigh 0 0 0\n", "thigh 0 0\n", "line 6: bone 'thigh' .expected 3 values, got 2.*test.asf is the skeleton"),
    ("amc", "thigh 0 0 0\n", "thihg 0 0 0\n", "line 6: unknown bone 'thihg'; did you mean 'thigh'.*test.asf was taken"),
    ("amc", "shin 0\n", "", "no channels of bone 'shin'"),
    ("amc", "\n2\n", "\n1\n", "frame 1 comes after frame 1"),
    ("amc", AMC[AMC.index("1\nroot") :], "", "no frames, so no motion"),
    ("amc", "\n1\nroot", "\nroot", "no frames, so no motion"),
]


@pytest.mark.parametrize(("which", "before", "after", "message"), BROKEN, ids=[f"{b[0]}-{b[3][:40]}" for b in BROKEN])
def test_what_is_broken_is_said_with_its_line(written, which, before, after, message):
    text = {"asf": ASF, "amc": AMC}
    assert before in text[which]
    text[which] = text[which].replace(before, after)
    with pytest.raises(FormatError, match=message):
        acclaim.read(written(text["asf"], text["amc"]), rate=120)


def test_a_motion_without_skeleton_and_a_skeleton_for_a_motion(written, tmp_path):
    path = written()
    (tmp_path / "test.asf").rename(tmp_path / "test.bak")
    with pytest.raises(
        FormatError, match=r"test_1.amc: a motion without its skeleton \(expected test\*.asf beside it, got none\)"
    ):
        acclaim.read(path, rate=120)
    (tmp_path / "test.bak").rename(tmp_path / "test.asf")
    with pytest.raises(FormatError, match="no section :root, so no skeleton"):
        acclaim.read(path, path, rate=120)
    with pytest.raises(FormatError, match="no frames, so no motion"):
        acclaim.read(tmp_path / "test.asf", tmp_path / "test.asf", rate=120)


@given(st.integers(0, len(ASF)), st.integers(0, len(AMC)), st.text("0123456789.-: \nabrxyz#", max_size=6))
def test_damage_anywhere_is_a_one_line_error_or_a_sound_motion(tmp_path_factory, at_asf, at_amc, dirt):
    folder = tmp_path_factory.mktemp("acclaim")
    (folder / "a.asf").write_text(ASF[:at_asf] + dirt + ASF[at_asf + len(dirt) :], encoding="latin-1")
    (folder / "a.amc").write_text(AMC[:at_amc] + dirt, encoding="latin-1")
    try:
        motion = acclaim.read(folder / "a.amc", rate=120)
    except IpcliError as error:
        check_message(error, folder)
    else:
        assert motion.positions.shape == (*motion.rotations.shape[:2], 3)


@pytest.mark.real
def test_hdm05_has_rigid_bones_of_the_lengths_of_the_skeleton(real_data, hdm05_clips):
    """Three actors: the far end of each bone is its length away, to rounding, in all frames."""
    for path in hdm05_clips:
        asf = acclaim.read_asf(acclaim.asf_of(path))
        motion = acclaim.read(path, asf)
        bones = motion.skeleton.bones()
        lengths = np.linalg.norm(motion.positions[:, bones[:, 1]] - motion.positions[:, bones[:, 0]], axis=-1)
        directions = np.array([np.linalg.norm(bone.direction) * bone.length for bone in asf.bones])
        np.testing.assert_allclose(lengths, np.broadcast_to(SCALE * directions[bones[:, 1]], lengths.shape), atol=1e-9)
        assert motion.rate == 120
        assert len(motion.skeleton.joints) == 31
        product = np.swapaxes(motion.rotations, -1, -2) @ motion.rotations
        assert np.abs(product - np.eye(3)).max() < 1e-12
        height = bone_lengths(motion.skeleton, motion.positions)[
            [motion.skeleton.joints.index(j) for j in ("lfemur", "ltibia")]
        ].sum()
        assert 0.6 < height < 1.1  # metres of leg: the unit is right


@pytest.mark.real
def test_hdm05_feet_stand_on_the_floor_and_heads_are_up(real_data, hdm05_clips):
    """The physics of a standing start: head above root above feet, soles near the floor, whatever the heading."""
    for path in hdm05_clips:
        motion = acclaim.read(path)
        height = {name: motion.positions[0, index, 1] for index, name in enumerate(motion.skeleton.joints)}
        assert height["head"] > height["root"] + 0.4 > height["lfoot"] + 1.0
        assert abs(min(height.values())) < 0.15
