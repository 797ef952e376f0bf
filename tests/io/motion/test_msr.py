"""MSR Action3D text: twenty lines a frame, turned right-handed, lost joints NaN, pixels refused."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.geometry.motion import heading
from ipcli.io.motion import groups, msr
from ipcli.io.motion.kinect import KINECT
from ipcli.io.motion.recordings import open_recordings
from tests.fixtures.errors import check_message

FILE = "a14_s03_e02_skeleton3D.txt"


def facing_the_sensor():
    """A person 2.5 m away who faces the sensor: the right side is on the left of its picture."""
    frame = {name: (0.0, 0.0, 2.5) for name in msr.JOINTS}
    for side, sign in (("right", -1), ("left", 1)):
        for part, height in (("shoulder", 0.4), ("elbow", 0.1), ("wrist", -0.1), ("hand", -0.2)):
            frame[f"{side}_{part}"] = (sign * 0.2, height, 2.5)
        for part, height in (("hip", -0.1), ("knee", -0.5), ("ankle", -0.9), ("foot", -1.0)):
            frame[f"{side}_{part}"] = (sign * 0.1, height, 2.5 - 0.15 * (part == "foot"))
    frame |= {
        "head": (0, 0.7, 2.5),
        "shoulder_center": (0, 0.45, 2.5),
        "spine": (0, 0.15, 2.5),
        "hip_center": (0, -0.05, 2.5),
    }
    return np.array([frame[name] for name in msr.JOINTS])


def save(folder, positions, name=FILE):
    lines = [f"{x} {y} {z} 1.0" for x, y, z in positions.reshape(-1, 3)]
    (folder / name).write_text("\n".join(lines) + "\n")
    return folder / name


def test_the_body_comes_upright_right_handed_and_faces_the_sensor(tmp_path):
    motion = msr.read(save(tmp_path, np.stack([facing_the_sensor()] * 2)))
    assert motion.skeleton == KINECT
    assert motion.rate == 15
    ahead = heading(KINECT, motion.positions, groups.find("kinect", KINECT))[:, :, 2]
    joints = KINECT.joints
    toes = motion.positions[:, joints.index("left_foot")] - motion.positions[:, joints.index("left_ankle")]
    assert (np.sum(ahead * toes, axis=-1) > 0.1).all()
    np.testing.assert_allclose(motion.positions[0, joints.index("head")], [0, 0.7, -2.5])


def test_the_name_tells_action_and_actor(tmp_path):
    save(tmp_path, np.stack([facing_the_sensor()] * 2))
    (tmp_path / "readme.txt").write_text("no motion")
    clips = open_recordings(tmp_path)
    assert (clips.labels, clips.actors) == (("forward kick",), ("s03",))
    assert msr.label_of("walk") is None


def test_a_lost_joint_is_nan(tmp_path):
    positions = np.stack([facing_the_sensor()] * 2)
    positions[1, msr.JOINTS.index("head")] = 0
    motion = msr.read(save(tmp_path, positions))
    assert np.isnan(motion.positions[1, KINECT.joints.index("head")]).all()
    assert np.isnan(motion.positions).sum() == 3


@pytest.mark.parametrize(
    ("change", "mentioned"),
    [(lambda p: p[:39], "20 lines a frame"), (lambda p: 100 * p, "Real3D")],
    ids=["cut", "pixels"],
)
def test_what_cannot_be_read_is_said(tmp_path, change, mentioned):
    with pytest.raises(FormatError) as raised:
        msr.read(save(tmp_path, change(np.concatenate([facing_the_sensor()] * 2))))
    check_message(raised.value, FILE, mentioned)
