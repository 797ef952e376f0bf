"""Gaze for recordings without any: on real places, in view, with the error that is asked for."""

import numpy as np
import pytest

from experiments.gaze import room
from experiments.saliency import generated_gaze


@pytest.fixture(scope="module")
def recording():
    return room.walk(room.Course(frames=5, width=320, height=240), 1).recording


def test_places_lie_on_the_walls_and_boxes_of_the_room(recording):
    points = generated_gaze.stereo_points(recording, 0)
    assert len(points) > 30
    camera = recording.truth[0][:3, 3]
    ways = points - camera
    lengths = np.linalg.norm(ways, axis=1)
    true, _ = room.meet(np.tile(camera, (len(points), 1)), ways / lengths[:, None], room.BOXES)
    assert np.median(np.abs(lengths / true - 1)) < 0.02


def test_looks_stay_in_view_and_turn_to_what_was_not_looked_at_lately():
    seen = np.ones((40, 3), bool)
    seen[:, 2] = False
    seen[10:20] = False
    looked = generated_gaze.attention(seen, np.random.default_rng(0))
    assert (looked[10:20] == -1).all()
    assert set(np.delete(looked, range(10, 20))) == {0, 1}
    stays = np.diff(np.flatnonzero(np.diff(looked[20:])))
    least, most = generated_gaze.DWELL
    assert (least <= stays).all()
    assert (stays <= most).all()


def test_samples_lie_around_the_place_by_the_error_in_degrees(recording):
    ahead = recording.truth[2]
    places = np.array([[-0.2, 0.1, 2.0], [0.2, 0.0, 2.0]]) @ ahead[:3, :3].T + ahead[:3, 3]
    pixels, seen = generated_gaze.views_of(recording, places)
    lines = generated_gaze.gaze_lines(recording, places, 0.5, 0)[1:]
    cells = [line.split(",") for line in lines]
    frames = [int(np.abs(recording.times - float(cell[0])).argmin()) for cell in cells]
    which = [int(cell[4].split()[1]) for cell in cells]
    off = np.array([[float(x) for x in cell[1:3]] for cell in cells]) - pixels[frames, which]
    degrees = np.degrees(np.linalg.norm(off, axis=1) / recording.cameras[0].intrinsics[0, 0])
    assert seen[frames, which].all()
    assert np.sqrt((degrees**2).mean()) == pytest.approx(0.5, rel=0.25)
