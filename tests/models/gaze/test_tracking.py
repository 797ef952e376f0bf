"""Frame after frame in the growing map: half a minute without a picture, and matches by descriptors alone."""

import numpy as np
import pytest

from experiments.gaze import room
from ipcli.models.gaze import evaluation, localise, tracking
from ipcli.models.gaze.features import StereoFeatures
from ipcli.models.gaze.parameters import Detection, Localisation
from tests.fixtures.gaze_walks import walk

SETTINGS = Localisation(detection=Detection(count=800))
pytestmark = pytest.mark.slow  # some seconds of pictures of a room
DARK = (5, 65)  # 30 s at 2 Hz


@pytest.fixture(scope="module")
def lost_and_found():
    course = room.Course(frames=72, width=320, height=240, rate=2.0, gaze_rate=2.0, dwell=(60.0, 80.0), dark=DARK)
    walked = walk(course, 5)
    return walked, localise.localise(walked.recording, SETTINGS, 0)


def test_after_half_a_minute_frames_are_recognised_where_they_are(lost_and_found):
    walked, path = lost_and_found
    assert [track.is_lost for track in path.tracks] == [DARK[0] <= k < DARK[1] for k in range(72)]
    assert path.tracks[DARK[1]].how == "recognised"
    poses = np.array(
        [np.linalg.inv(track.pose) if not track.is_lost else np.full((4, 4), np.nan) for track in path.tracks]
    )
    assert evaluation.path_errors(poses, walked.recording.truth).rigid.rmse < 0.01


def test_the_map_is_not_doubled(lost_and_found):
    _, path = lost_and_found
    scene = path.scene
    first = np.array([min(seen, default=-1) for seen in scene.observers[: scene.count]])
    number = np.array([frame.number for frame in scene.frames])
    known = np.flatnonzero(first >= 0)
    old, new = known[number[first[known]] < DARK[0]], known[number[first[known]] >= DARK[1]]
    near = np.linalg.norm(scene.points[new, None] - scene.points[old], axis=2)
    partner = near.argmin(axis=1)
    alike = scene.descriptors[new].astype(float) - scene.descriptors[old[partner]]
    twice = (near.min(axis=1) < 0.02) & (np.square(alike).sum(axis=1) < 30000)
    rests = np.mean([len(track.ids) / track.stereo for track in path.tracks[DARK[1] :]])
    assert rests > 0.3  # on points of the map
    assert twice.sum() < 0.1 * len(old)


def test_descriptors_match_when_both_ways_agree_and_the_second_is_clearly_worse():
    rng = np.random.default_rng(0)
    mine = rng.integers(0, 90, (5, 128)).astype(np.uint8)
    theirs = np.concatenate([mine[[3, 0, 4]], rng.integers(0, 90, (2, 128)).astype(np.uint8)])
    theirs[1] += 2
    theirs[2] += np.arange(128, dtype=np.uint8) % 2
    twin = np.concatenate([theirs, mine[4:] + np.arange(1, 129, dtype=np.uint8) % 2])  # as near: no clear best
    none = np.full((len(twin), 2), 0.0)
    features = StereoFeatures(
        none, none, np.full((len(twin), 3), np.nan), np.ones(len(twin)), twin, np.arange(len(twin))
    )
    chosen, ids = tracking._described(features, mine, np.array([10, 11, 12, 13, 14]), None)
    assert dict(zip(ids.tolist(), chosen.tolist(), strict=True)) == {13: 0, 10: 1}
