"""Points of regard in pictures and in the panorama of them."""

import numpy as np
import pytest

from ipcli.report.gaze.panorama import LOOK, NOW, panorama, with_regards

GREY = 90


@pytest.fixture
def run():
    """One level camera of 160 x 120 that looks ahead, kept at half its size, and a point of regard in its middle."""
    return {
        "pictures": np.full((1, 60, 80, 3), GREY, np.uint8),
        "picture_frames": np.array([0]),
        "lost": np.zeros(1, np.uint8),
        "world_from_rig": np.eye(4)[None],
        "rig/sizes": np.array([[160, 120]]),
        "rig/intrinsics": np.array([[[80.0, 0, 79.5], [0, 80, 59.5], [0, 0, 1]]]),
        "rig/distortion": np.full((1, 8), np.nan),
        "rig/models": np.array(["pinhole"]),
        "por/points": np.array([[0.0, 0.0, 2.0]]),
        "por/outcome": np.array(["hit"]),
        "shown/frame": np.array([0, 0]),
        "shown/pixels": np.array([[80.0, 60.0], [40.0, 20.0]]),
    }


def test_the_picture_is_marked_and_the_artefact_left_as_it_was(run):
    image = with_regards(run, 0)
    assert tuple(image[30, 45]) == NOW  # five pixels beside where the nearest sample lies in the small picture
    assert tuple(image[10, 25]) == LOOK
    assert (run["pictures"] == GREY).all()


def test_the_panorama_shows_the_picture_with_a_ring_where_the_point_lies(run):
    image = panorama(run)
    middle = np.array(image.shape[:2]) // 2
    assert tuple(image[tuple(middle)]) == (GREY,) * 3
    rings = np.argwhere(np.ptp(image.astype(int), axis=2) > 60)
    assert np.abs(rings.mean(axis=0) - middle).max() < 2


def test_a_recording_that_was_lost_throughout_has_an_empty_panorama(run):
    image = panorama(run | {"lost": np.ones(1, np.uint8)})
    assert len(np.unique(image)) == 1
