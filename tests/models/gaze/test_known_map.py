"""Another wearer with a single camera in the map of an earlier run with two."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.gaze import room
from ipcli.errors import NoSolution
from ipcli.geometry import lie
from ipcli.measurements.recording import Frame, PictureModel
from ipcli.models.gaze import evaluation, known_map, localise
from ipcli.models.gaze.experiment import experiment
from ipcli.models.gaze.features import detect
from ipcli.models.gaze.parameters import Detection, Localisation, Looking
from tests.fixtures.gaze_walks import walk

SETTINGS = Localisation(looking=Looking(sigma=2**-0.5), detection=Detection(count=800))
COURSE = room.Course(frames=24, width=320, height=240, rate=6.0, gaze_rate=24.0)


@pytest.fixture(scope="module")
def earlier():
    walked = walk(COURSE, 5)
    return walked, experiment(walked.recording, SETTINGS, 0)


def _one_camera(recording):
    return replace(recording, cameras=recording.cameras[:1], load=lambda k: Frame(recording.load(k).left))


def test_one_camera_is_localised_in_the_earlier_world_and_the_map_stays(earlier):
    walked, a = earlier
    other = walk(replace(COURSE, frames=10), 8)
    known = known_map.known_map(a)
    before = known.scene.points.copy()
    b = experiment(_one_camera(other.recording), SETTINGS, 0, known=known)
    posed = b["lost"] == 0
    assert posed.mean() > 0.6
    truth = lie.se3_inverse(walked.recording.truth[:1]) @ other.recording.truth[posed]
    off = np.linalg.norm(b["world_from_rig"][posed, :3, 3] - truth[:, :3, 3], axis=1)
    assert np.median(off) < 0.02
    assert off.max() < 0.1
    np.testing.assert_array_equal(b["map/points"], before)
    assert len(b["rig/models"]) == 1
    assert (b["map/sightings"][:, 1] == 0).all()
    hit = b["por/outcome"] == "hit"
    assert hit.mean() > 0.3
    world = lie.se3_inverse(walked.recording.truth[:1])[0]
    places = room.TARGETS[other.looked_at][hit] @ world[:3, :3].T + world[:3, 3]
    errors, squares = evaluation.target_errors(b["por/points"][hit], b["por/covariance"][hit], places, np.eye(4))
    assert np.median(errors) < 0.12
    assert evaluation.coverage(squares)[0.95] > 0.8


def test_pictures_of_another_room_are_lost_not_placed(earlier):
    _, a = earlier
    noise = np.random.default_rng(0).integers(0, 255, (3, 240, 320), dtype=np.uint8)
    recording = replace(_one_camera(walk(replace(COURSE, frames=3), 5).recording), load=lambda k: Frame(noise[k]))
    path = localise.localise(recording, SETTINGS, 0, known=known_map.known_map(a).scene)
    assert all(track.is_lost for track in path.tracks)


def test_a_run_without_descriptors_or_frames_is_no_map(earlier):
    _, a = earlier
    with pytest.raises(NoSolution, match="no descriptors"):
        known_map.known_map({name: value for name, value in a.items() if name != "map/descriptors"})
    with pytest.raises(NoSolution, match="no map"):
        known_map.known_map(a | {"map/sightings": np.empty((0, 3), np.int64)})


def test_a_model_is_described_by_its_pictures_where_they_have_features():
    image = walk(COURSE, 5).recording.load(0).left
    found, _, described = detect(image, SETTINGS.detection)
    pixels = np.concatenate([found[:60] + [1.0, 0.5], [[-50.0, -50.0]]])  # the last is at no feature
    points = np.random.default_rng(0).normal(size=(len(pixels), 3))
    poses, shown, none = np.eye(4)[None], (np.arange(len(pixels)),), np.zeros(len(pixels), np.uint8)
    model = PictureModel(points, none, poses, shown, (pixels,), lambda k: image, ())
    known = known_map.map_of_model(model, SETTINGS.detection)
    np.testing.assert_array_equal(known.scene.points, points[:-1])
    assert (known.scene.descriptors == described[:60]).all(axis=1).mean() > 0.8  # the rest have a nearer neighbour
    assert known.scene.points_of([0]).tolist() == list(range(60))
    with pytest.raises(NoSolution, match="no point of the model"):
        known_map.map_of_model(replace(model, load=lambda k: np.zeros_like(image)), SETTINGS.detection)
