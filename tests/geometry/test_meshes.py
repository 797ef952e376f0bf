"""Balls and boxes of triangles against their closed forms."""

import numpy as np
import pytest
import trimesh

from ipcli.geometry import meshes

BALL = trimesh.creation.icosphere(3)
BOX = trimesh.creation.box((1.0, 2.0, 3.0))


def of(mesh):
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def test_each_edge_of_a_closed_mesh_stands_there_twice():
    ends, count = np.unique(meshes.edges(of(BALL)[1]), axis=0, return_counts=True)
    assert (count == 2).all()
    assert (ends[:, 0] < ends[:, 1]).all()
    assert len(BALL.vertices) - len(ends) + len(BALL.faces) == 2  # Euler


def test_area_and_volume_are_those_of_a_box():
    assert meshes.areas(*of(BOX)).sum() == pytest.approx(22.0)
    assert meshes.volume(*of(BOX)) == pytest.approx(6.0)
    vertices, faces = of(BOX)
    assert meshes.volume(vertices + 5.0, faces[:, ::-1]) == pytest.approx(6.0)  # wherever it is, however it is wound


def test_normals_of_a_ball_are_its_vertices_and_those_of_no_triangle_are_zero():
    vertices, faces = of(BALL)
    found = meshes.vertex_normals(np.concatenate([vertices, [[9.0, 9.0, 9.0]]]), faces)
    np.testing.assert_allclose(found[:-1], vertices, atol=0.02)  # 0.011 here: facets
    np.testing.assert_array_equal(found[-1], 0.0)


def test_what_a_mesh_winds_around_is_inside_also_where_two_overlap():
    vertices, faces = of(BOX)
    twice = np.concatenate([vertices, vertices + [0.5, 0.0, 0.0]]), np.concatenate([faces, faces + len(vertices)])
    points = np.array([[0.0, 0.0, 0.0], [0.25, 0.5, 1.0], [0.9, 0.0, 0.0], [1.2, 0.0, 0.0], [0.0, 1.2, 0.0]])
    assert meshes.contains(*twice, points).tolist() == [True, True, True, False, False]
