from dataclasses import replace

import numpy as np
import pytest

from ipcli.geometry.distances import apart
from ipcli.geometry.orthographic import of_view
from ipcli.geometry.part_masks import framed, render
from ipcli.geometry.voxels import VoxelGrid
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal import whole
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.limbs import TREE, four_legged
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.models.animal.placing import placed
from ipcli.models.animal.reposed import fields_of, reposed, tells_shape


def looks(pose, views, prefix=""):
    vertices, faces, labels, _ = four_legged(pose, spacing=0.06)
    images = []
    for view in views:
        camera, shape = framed(vertices, of_view(view), 160)
        seen, _ = render(vertices, faces, labels, camera, shape)
        images.append(PartImage(prefix + view, seen, view, is_reference=not prefix))
    return images


def test_two_lines_of_view_tell_shape():
    left, right, top = looks("walking", ("left", "right", "top"), "other ")
    assert tells_shape([left, top])
    assert not tells_shape([left, right])
    assert not tells_shape([])
    assert tells_shape([left, replace(top, view="40,15")])


def test_the_fields_of_a_mesh_are_its_distances_and_parts_meet():
    vertices, faces, labels, _ = four_legged(spacing=0.06)
    grid = VoxelGrid.around(vertices.min(axis=0), vertices.max(axis=0), 0.08)
    fields = fields_of(vertices, faces, labels - 1, grid, len(TREE))
    union = np.minimum.reduce(fields)
    radius = 0.36  # of the torso in its middle
    middle = tuple(np.rint((np.array([0.0, 0.0, -0.04]) - grid.origin) / grid.spacing).astype(int))
    assert union[middle] == pytest.approx(-radius / grid.spacing, abs=0.6)
    assert fields[0][middle] == union[middle]
    assert all(field[middle] >= 0.5 for field in fields[1:])


@pytest.mark.slow
def test_another_pose_brings_the_model_nearer_to_the_truth():
    params = Modelling(inflation=Inflation(triangles=300), volume=Volume(voxels=48))
    others = looks("walking", ("left", "right", "front", "back", "top"), "other ")
    images = looks("standing", ("left", "front"))
    cameras = placed(images, TREE, params)
    heights = {key: a.picture for key, a in lift_all([*images, *others], TREE, params.inflation).items()}
    fields, shots, grid = whole.parts_of(images, cameras, TREE, heights, params.volume)
    bent, overlap = reposed(others, shots, grid, fields, TREE, heights, params)
    vertices, faces, _, _ = four_legged("standing", spacing=0.06)
    camera, _ = framed(vertices, of_view("left"), 160)

    def error(parts):
        surface = whole.surface(parts, shots, grid, params.volume)
        middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
        placed_there = (surface.vertices - middle) / camera.scale + (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        return apart((placed_there.astype(np.float64), surface.faces), (vertices, faces)).mean

    assert overlap > 0.85
    assert error(bent) < 0.9 * error(fields)
