"""Baselines are what they are named after."""

import numpy as np
import pytest
import trimesh

from ipcli.models.animal import baselines
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from tests.fixtures import limbs


@pytest.fixture(scope="module")
def taken():
    return tuple(zip(*limbs.shots(("left", "front", "top")), strict=True))


def volume(mesh):
    body = trimesh.Trimesh(*mesh, process=False)
    assert body.is_watertight
    return body.volume


def test_the_hull_holds_the_body_and_rounding_shrinks_it(taken):
    images, cameras = taken
    truth = trimesh.Trimesh(*limbs.mesh()[:2], process=False)
    hull = baselines.visual_hull(images, cameras, 56)
    rounded = baselines.visual_hull(images, cameras, 56, is_rounded=True)
    assert volume(hull) > volume(rounded) > 0.95 * truth.volume
    # the vertices of the truth lie within the hull, up to a voxel
    assert (trimesh.Trimesh(*hull, process=False).bounds[0] < truth.bounds[0] + 0.06).all()


def test_the_whole_mask_keeps_its_outline(taken):
    images, cameras = taken
    vertices, faces = baselines.whole_mask(images[0], cameras[0], Inflation())
    assert volume((vertices, faces)) > 0
    truth = limbs.mesh()[0]
    assert np.ptp(vertices[:, 0]) == pytest.approx(np.ptp(truth[:, 0]), rel=0.04)
    assert np.ptp(vertices[:, 2]) == pytest.approx(np.ptp(truth[:, 2]), rel=0.04)


def test_the_thesis_as_printed_is_closed(taken):
    images, cameras = taken
    params = Modelling(Inflation(triangles=300), Volume(voxels=48, steps=6))
    assert volume(baselines.as_printed(images, cameras, limbs.TREE, params)) > 0
