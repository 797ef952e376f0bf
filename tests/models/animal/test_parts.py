"""Carving the visual hull apart along the labels."""

import pytest

from ipcli.models.animal import whole
from ipcli.models.animal.parts import carve
from tests.fixtures import limbs

VIEWS = ("left", "right", "front", "back", "top")


@pytest.fixture(scope="module")
def taken():
    return limbs.shots(VIEWS)


def test_carving_leaves_each_part_where_its_labels_allow(taken):
    images, truth = zip(*taken, strict=True)
    grid = whole.grid_of(images, truth, 56)
    fields = carve(whole.shots_of(images, truth, grid), limbs.TREE)
    points = grid.points()
    for name, field in zip(limbs.TREE.names, fields, strict=True):
        core = limbs.capsule(points, *limbs.CAPSULES[name]) < -2 * grid.spacing
        if name in ("fore", "hind"):  # their upper ends lie within the torso, where no image shows them
            core &= points[..., 2] < -0.4
        assert (field[core] < 1.0).mean() > 0.97
