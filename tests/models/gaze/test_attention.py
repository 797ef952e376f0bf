"""Coherent subsequences of a camera that flies past known points."""

import numpy as np
import pytest

from ipcli.models.gaze import attention
from ipcli.models.gaze.features import StereoFeatures
from ipcli.models.gaze.localise import Path
from ipcli.models.gaze.parameters import Keyframes
from ipcli.models.gaze.scene_map import NONE, SceneMap
from ipcli.models.gaze.tracking import Track
from tests.fixtures.gaze_rig import stereo_rig

COUNT = 60


@pytest.fixture(scope="module")
def flight():
    """18 frames, 5 cm a frame to the right: the first begins the map with all points, as the tracker leaves it."""
    rng, rig = np.random.default_rng(4), stereo_rig()
    points = rng.uniform([-2, -1.5, 3], [2, 1.5, 6], (COUNT, 3))
    tracks, scene = [], SceneMap()
    for k in range(18):
        pose = np.eye(4)
        pose[0, 3] = -0.05 * k
        inside = points + pose[:3, 3]
        pixels = (rig.intrinsics[0] @ (inside / inside[:, 2:]).T).T[:, :2]
        ids, seen = (np.empty(0, int), np.empty((0, 2))) if k == 0 else (np.arange(COUNT), pixels)
        sigma = np.ones(len(ids))
        tracks.append(Track(k, pose, np.eye(6), ids, seen, seen, sigma, how="predicted" if k else "first"))
        if k == 0:
            found = StereoFeatures(
                pixels, pixels, points, np.ones(COUNT), np.zeros((COUNT, 128), np.uint8), np.arange(COUNT)
            )
            tracks[0].position = scene.add_frame(0, found, pose, np.full(COUNT, NONE))
    online = np.stack([track.pose for track in tracks])
    return Path(rig, tracks, scene, online, None, True)


def split(path, pixels=None, points=None):
    count = len(path.tracks)
    pixels = np.tile(path.rig.intrinsics[0, :2, 2], (count, 1)) if pixels is None else pixels
    points = np.full((count, 3), np.nan) if points is None else points
    return attention.subsequences(path, pixels, points, Keyframes(), np.radians(1.0))


def test_every_frame_is_compared_with_the_first_though_its_pose_rests_on_no_point(flight):
    found = split(flight)
    assert np.isnan(found.score_f[0])
    assert (found.score_f[2:15] < found.score_h[2:15]).all()  # no plane, and the camera moved 10 cm or more
    assert (found.matches[1:] == COUNT).all()


def test_without_gaze_a_moving_head_begins_anew_after_the_longest_subsequence(flight):
    found = split(flight)
    assert np.flatnonzero(found.keyframes).tolist() == [0, Keyframes().longest]
    assert found.numbers.tolist() == [0] * 15 + [1] * 3


def test_a_gaze_that_turns_elsewhere_for_two_frames_begins_a_subsequence(flight):
    points = np.tile([0.0, 0.0, 4.0], (18, 1))
    points[9:] = [1.0, 0.0, 4.0]  # 14 degrees away, of a gaze known to one
    found = split(flight, points=points)
    assert np.flatnonzero(found.keyframes).tolist() == [0, 10]
    assert found.parted[9] == pytest.approx(np.degrees(np.arctan2(1 - 0.45, 4) + np.arctan2(0.45, 4)), rel=0.05)


def test_a_lost_frame_ends_its_subsequence(flight):
    lost = Track(5, np.full((4, 4), np.nan), np.eye(6), np.empty(0, int), *[np.empty((0, 2))] * 2, np.empty(0))
    path = Path(flight.rig, [*flight.tracks[:5], lost, *flight.tracks[6:]], flight.scene, flight.online, None, True)
    found = split(path)
    assert found.numbers[4:7].tolist() == [0, -1, 1]
