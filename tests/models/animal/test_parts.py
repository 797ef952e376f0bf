"""Carving the visual hull apart along the labels."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import by_angles, of_view
from ipcli.models.animal import whole
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.parameters import Inflation
from ipcli.models.animal.parts import all_lean, carve, rounded
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


def test_parts_stand_upright_though_the_hull_of_an_oblique_view_leans():
    images, truth = zip(*limbs.shots(("left", by_angles(40.0, 10.0))), strict=True)
    grid = whole.grid_of(images, truth, 48)
    shots = whole.shots_of(images, truth, grid)
    heights = {key: a.picture for key, a in lift_all(images, limbs.TREE, Inflation(triangles=300)).items()}
    carved = carve(shots, limbs.TREE)
    torso = rounded(carved, shots, heights)[0]
    points = grid.points()

    def lean(field):
        """How far the middle of a part moves to its left on the way forward."""
        x, y, _ = points[field < 0].T
        return np.polyfit(x, y, 1)[0]

    assert abs(lean(carved[0])) > 0.4
    assert abs(lean(torso)) < 0.12


@pytest.mark.parametrize(
    ("views", "lean"),
    [(("left", "front"), False), (("left", by_angles(40, 15)), True), (("left", by_angles(40, 15), "top"), False)],
)
def test_views_lean_unless_two_are_across_each_other(views, lean):
    assert all_lean([of_view(view)[2] for view in views]) == lean
