import numpy as np
import pytest

from ipcli.models.saliency import vertex_features
from tests.fixtures.fixation_sets import bumpy


@pytest.fixture(scope="module")
def ball():
    points, normals, bump = bumpy(0)
    return vertex_features.features(points, normals), bump


def test_features_are_finite_and_one_a_vertex(ball):
    found, bump = ball
    assert all(part.shape == bump.shape and np.isfinite(part).all() for part in found.values())


@pytest.mark.parametrize("name", ["convexity of 32", "convexity 0.08"])
def test_a_bump_is_convex(ball, name):
    found, bump = ball
    assert np.median(found[name][bump > 0.8]) > np.percentile(found[name], 90)


def test_convexity_of_a_ball_is_positive_and_that_of_its_inside_is_not():
    points, normals, _ = bumpy(1)
    points = normals.copy()
    outside = vertex_features.features(points, normals)["convexity of 16"]
    inside = vertex_features.features(points, -normals)["convexity of 16"]
    assert np.median(outside) > 0
    assert outside == pytest.approx(-inside)


def test_features_but_for_the_spacing_do_not_change_with_size():
    points, normals, _ = bumpy(2)
    one, other = (vertex_features.features(scale * points, normals) for scale in (1.0, 4.0))
    for name in ("convexity of 16", "roughness 0.04", "Lee's mesh saliency", "height"):
        assert one[name] == pytest.approx(other[name], abs=1e-6)
    assert other[vertex_features.SPACING] == pytest.approx(4 * one[vertex_features.SPACING])


def test_sites_are_no_more_than_asked_for_and_even():
    points, normals, _ = bumpy(3)
    dense = np.concatenate([points, points[:200] + 1e-5])
    ground = vertex_features.sites(dense, np.concatenate([normals, normals[:200]]), 300)
    assert 200 < len(ground.places) <= 300
    assert np.linalg.norm(ground.normals, axis=1) == pytest.approx(1)


def test_smoothing_keeps_what_is_constant_and_interpolation_too():
    points, normals, _ = bumpy(4)
    ground = vertex_features.sites(points, normals, 300)
    ones = np.ones(len(ground.places))
    assert vertex_features.smoother(ground, 0.1) @ ones == pytest.approx(ones)
    assert ground.at(points, {"a": 3 * ones})["a"] == pytest.approx(3)


def test_ranks_are_shares_and_ties_are_alike():
    assert vertex_features.ranks(np.array([5.0, 1.0, 5.0, 9.0])) == pytest.approx([0.5, 0.125, 0.5, 0.875])


def test_normals_of_vertices_point_out_of_a_mesh():
    import trimesh

    mesh = trimesh.creation.icosphere(2)
    found = vertex_features.upright_normals(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    assert found == pytest.approx(np.asarray(mesh.vertices), abs=0.03)
