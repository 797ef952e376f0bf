"""Cameras of images whose view has no name."""

import numpy as np

from ipcli.geometry.orthographic import Orthographic, angle_between, looking, of_view
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.models.animal.placing import _deepest_first, placed
from tests.fixtures import limbs

QUICK = Modelling(Inflation(triangles=400), Volume(voxels=56, steps=12))
FITS = {"right": 0.9, "top": 0.3, "front": 0.5}  # how well each was found


def test_a_view_without_a_name_is_found():
    rotation = looking(40.0, 15.0)
    taken = limbs.shots(("left", "front", "askew"), rotations={"askew": rotation})
    images, _ = zip(*taken, strict=True)
    found = placed(images, limbs.TREE, QUICK)
    assert angle_between(found[2].rotation, rotation) < 2.0


def test_the_first_camera_found_beside_one_view_is_one_that_tells_the_depth():
    left = Orthographic(of_view("left"), 1.0, np.zeros(2))
    found = {view: (Orthographic(of_view(view), 1.0, np.zeros(2)), fit) for view, fit in FITS.items()}
    assert _deepest_first(found, left) == ["front", "top", "right"]


def test_a_front_view_is_found_from_one_named_view():
    taken = limbs.shots(("left", "ahead"), rotations={"ahead": of_view("front")})
    images, _ = zip(*taken, strict=True)
    assert angle_between(placed(images, limbs.TREE, QUICK)[1].rotation, of_view("front")) < 12.0
