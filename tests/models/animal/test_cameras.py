"""Scales and shifts of cameras from silhouettes alone."""

import pytest

from ipcli.models.animal import cameras as cm
from tests.fixtures import limbs

VIEWS = ("left", "right", "front", "back", "top")


@pytest.fixture(scope="module")
def taken():
    return limbs.shots(VIEWS)


def test_scales_and_shifts_come_from_the_silhouettes(taken):
    images, truth = zip(*taken, strict=True)
    found = cm.align([i.silhouette for i in images], [t.rotation for t in truth])
    for camera, true in zip(found, truth, strict=True):
        assert camera.scale * truth[0].scale / true.scale == pytest.approx(1.0, rel=0.01)
    assert cm.frontier_error([i.silhouette for i in images], found) < 0.6  # pixels of the first image
