"""What is told of a rig and of a gaze before anybody trusts what comes of them."""

from dataclasses import replace

import numpy as np

from ipcli.measurements.recording import Gaze
from ipcli.models.gaze import checks
from tests.fixtures.gaze_rig import stereo_rig


def moved(place):
    """The rig with its second camera elsewhere."""
    rig = stereo_rig()
    poses = rig.cam_from_rig.copy()
    poses[1, :3, 3] = -poses[1, :3, :3] @ place
    return replace(rig, cam_from_rig=poses)


def test_a_sound_rig_is_not_doubted():
    assert checks.rig_words(stereo_rig()) == []
    assert checks.rig_words(stereo_rig(offset=1.5)) == []
    assert checks.rig_words(moved([0.0, 0.1, 0.0])) == []  # one above the other


def test_millimetres_a_camera_on_the_other_side_and_large_offsets_are_told():
    (unit,) = checks.rig_words(moved([120.0, 0.0, 0.0]))
    assert unit.startswith("the cameras are 120 m apart")
    (side,) = checks.rig_words(moved([-0.12, 0.0, 0.0]))
    assert "to the left of the first" in side
    (off,) = checks.rig_words(stereo_rig(offset=-15.6))
    assert off.startswith("the disparities are -15.6 px off")


def gaze(pixels):
    return Gaze(np.arange(len(pixels)) / 30, pixels, np.ones(len(pixels), bool))


def test_shares_of_the_picture_are_no_pixels():
    shares = np.random.default_rng(0).uniform(0, 1, (100, 2))
    (words,) = checks.gaze_words(gaze(shares))
    assert "shares of the picture" in words
    assert checks.gaze_words(gaze(100 * shares)) == []
    assert checks.gaze_words(gaze(np.full((100, 2), np.nan))) == []
    assert checks.gaze_words(None) == []
