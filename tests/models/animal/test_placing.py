"""Cameras of images whose view has no name."""

from ipcli.geometry.orthographic import angle_between, looking, named
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.models.animal.placing import placed
from tests.fixtures import limbs

QUICK = Modelling(Inflation(triangles=400), Volume(voxels=56, steps=12))


def test_a_view_without_a_name_is_found():
    rotation = looking(40.0, 15.0)
    taken = limbs.shots(("left", "front", "askew"), rotations={"askew": rotation})
    images, _ = zip(*taken, strict=True)
    found = placed(images, limbs.TREE, QUICK)
    assert angle_between(found[2].rotation, rotation) < 4.0


def test_a_front_view_is_found_from_one_named_view():
    taken = limbs.shots(("left", "ahead"), rotations={"ahead": named("front")})
    images, _ = zip(*taken, strict=True)
    assert angle_between(placed(images, limbs.TREE, QUICK)[1].rotation, named("front")) < 12.0
