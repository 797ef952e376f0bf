"""A run laid on landmarks: by marks in pictures, by labels of the gaze, with scale or without."""

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.geometry import lens, lie
from ipcli.measurements.recording import Landmarks
from ipcli.models.gaze import world

K = np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]])
LENS = np.array([-0.1, 0.02, 0.0, 0.0])
PLACES = np.array([[0.5, 0.2, 3.0], [-0.6, 0.1, 2.5], [0.1, -0.4, 4.0], [0.3, 0.4, 2.2]])
NAMES = ("door", "lamp", "clock", "cup")


def _run():
    """Five poses that see four places; gaze on the first three of them."""
    poses = lie.se3_exp(np.column_stack([np.zeros((5, 2)), 0.02 * np.arange(5), 0.15 * np.arange(5), np.zeros((5, 2))]))
    distortion = np.full((1, 12), np.nan)
    distortion[0, :4] = LENS
    return {
        "names": np.array([f"{k:05d}" for k in range(5)]), "lost": np.zeros(5, np.uint8), "world_from_rig": poses,
        "online": poses.copy(), "covariance": np.tile(np.diag([1.0, 1, 1, 4, 4, 4]) * 1e-6, (5, 1, 1)),
        "observer": np.ones((5, 3)), "map/points": PLACES.copy(), "rig/intrinsics": K[None],
        "rig/models": np.array(["radtan"]), "rig/distortion": distortion, "rig/cam_from_rig": np.eye(4)[None],
        "subsequences/points": PLACES[:1], "subsequences/extent": np.ones(1),
        "por/points": PLACES[[0, 0, 1, 2]], "por/covariance": np.tile(np.diag([1.0, 1, 9]) * 1e-4, (4, 1, 1)),
        "por/outcome": np.array(["hit"] * 4), "por/origins": np.zeros((4, 3)), "por/directions": np.eye(3)[[2] * 4],
        "gaze/labels": np.array(["door", "door", "lamp", "clock"]),
    }  # fmt: skip


def _other(points, scale=1.0):
    turn = lie.exp(np.array([0.3, -1.2, 0.4]))
    return scale * points @ turn.T + [5.0, -2, 1]


def _marks(a, which, frames):
    rows = []
    for i in which:
        for k in frames:
            seen = np.linalg.inv(a["world_from_rig"][k]) @ [*PLACES[i], 1]
            u, v = lens.pixels_of(lens.distort("radtan", LENS, seen[:2] / seen[2]), K)
            rows.append((i, str(k), float(u), float(v)))  # 00003 became 3 in the table
    return tuple(rows)


def test_marks_in_frames_give_the_places_through_the_lens():
    a = _run()
    landmarks = Landmarks(NAMES, _other(PLACES), _marks(a, range(4), (0, 3, 4)))
    b = world.laid_on(a, landmarks, with_scale=False)
    np.testing.assert_allclose(b["map/points"], _other(PLACES), atol=1e-6)
    np.testing.assert_allclose(b["landmarks/found"], landmarks.places, atol=1e-6)
    assert b["landmarks/scale"] == 1


def test_labels_of_the_gaze_do_too_and_scale_reaches_everything_in_metres():
    a = _run()
    b = world.laid_on(a, Landmarks(NAMES, _other(PLACES, 2.0)), with_scale=True)
    assert b["landmarks/scale"] == pytest.approx(2)
    assert np.isnan(b["landmarks/found"][3]).all()  # nobody looked at the cup
    np.testing.assert_allclose(b["por/points"], _other(a["por/points"], 2.0), atol=1e-9)
    np.testing.assert_allclose(np.trace(b["por/covariance"][0]), 4 * np.trace(a["por/covariance"][0]))
    np.testing.assert_allclose(b["covariance"][0].diagonal(), np.array([1.0, 1, 1, 16, 16, 16]) * 1e-6)
    seen = np.linalg.inv(b["world_from_rig"]) @ np.append(b["map/points"][0], 1)
    before = np.linalg.inv(a["world_from_rig"]) @ np.append(PLACES[0], 1)
    np.testing.assert_allclose(seen[:, :3], 2 * before[:, :3], atol=1e-9)  # the pictures stay as they are


def test_too_few_and_landmarks_on_a_line_are_refused():
    a = _run()
    with pytest.raises(NoSolution, match="only 2 of 2 landmarks"):
        world.laid_on(a, Landmarks(NAMES[:2], PLACES[:2]), with_scale=False)
    line = np.array([[0.0, 0, 1], [0, 0, 2], [0, 0, 3]])
    with pytest.raises(NoSolution, match="on one line"):
        world.laid_on(a, Landmarks(NAMES[:3], line), with_scale=False)
