"""Observations looked up by a map: exact where the map is, blind to their own noise, and no more than forward
projection knows.
"""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.geometry.cameras import rays
from ipcli.inverse.regularize.parameters import Solver
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.observations import Units
from ipcli.models.fusion.parameters import Fusion
from ipcli.models.fusion.reassociation import reassociate
from ipcli.models.fusion.reprojection import Layers, reproject_all
from tests.fixtures.fusion_scenes import WALL, camera, pose_at, scene

SHAPE = (60, 80)
POSES = [pose_at((0.05 * i, 0.02 * (i % 2), 0.03 * i), 0.03 * i) for i in (-2, -1, 0, 1, 2)]


def units(inverse=False, scale=0.02):
    return Units(inverse, 0.0, scale, floor=1e-6)


def wall_views(noise=0.0):
    """Five views of the slanted wall alone, in float64 exactly, with their noise on top."""
    found = []
    for i, pose in enumerate(POSES):
        rotation, origin = pose[:3, :3], np.linalg.inv(pose)[:3, 3]
        truth = (2.5 - WALL @ origin) / (rays(SHAPE, camera(SHAPE)) @ rotation @ WALL)
        depth = truth + np.random.default_rng(i).laplace(0, noise, SHAPE) if noise else truth
        found.append(View(str(i), depth.astype(np.float32), camera(SHAPE), pose, truth=truth.astype(np.float32)))
    return found


def nothing(views, reference):
    return Layers(np.full((len(views), *reference.depth.shape), np.inf, np.float32), None)


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_with_the_true_map_views_without_noise_say_exactly_the_truth(inverse):
    views = wall_views()
    truth = views[2].truth
    layers = reassociate(truth, views, views[2], nothing(views, views[2]), units(inverse)).depth
    seen = np.isfinite(layers)
    assert seen.mean() > 0.85
    assert seen[2].all()
    np.testing.assert_allclose(layers[seen], np.broadcast_to(truth, layers.shape)[seen], rtol=2e-6)


def test_without_noise_looking_up_and_forward_projection_agree_to_half_a_pixel():
    views = [replace(view, depth=view.truth) for view in scene()]
    forward = reproject_all(views, views[2])
    layers = reassociate(views[2].truth, views, views[2], forward, units())
    both = np.isfinite(forward.depth) & np.isfinite(layers.depth)
    slope = np.abs(np.gradient(views[2].truth)).max(axis=0)
    apart = np.abs(np.where(both, layers.depth, 0) - np.where(both, forward.depth, 0))
    assert both.mean() > 0.85
    assert (apart <= 1.5 * slope + 1e-5)[both].mean() > 0.995
    assert (np.isfinite(layers.depth) >= np.isfinite(forward.depth)).all()


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_what_a_look_up_adds_to_the_truth_is_the_noise_of_the_pixel_and_no_bias(inverse):
    """Forward projection takes the nearest of the points that noise has scattered, here by pixels; looking up
    does not.
    """
    views = wall_views(noise=0.1)
    reference, truth = views[2], views[2].truth
    layers = reassociate(truth, views, reference, nothing(views, reference), units(inverse, scale=1.0)).depth
    others = [0, 1, 3, 4]
    error = (layers - truth)[others]
    error = error[np.isfinite(error)]
    forward = (reproject_all(views, reference).depth - truth)[others]
    forward = forward[np.isfinite(forward)]
    assert np.mean(np.abs(error)) == pytest.approx(0.1, rel=0.15)
    assert abs(np.median(error)) < 0.01
    assert abs(np.median(error)) < 0.25 * abs(np.median(forward))


def test_a_map_that_is_wrong_by_more_than_the_gate_leaves_the_forward_projection_as_it_is():
    views = wall_views()
    forward = reproject_all(views, views[2])
    layers = reassociate(views[2].truth * np.float32(1.2), views, views[2], forward, units())
    np.testing.assert_array_equal(layers.depth, forward.depth)


def test_given_confidences_go_with_the_pixel_that_was_looked_up():
    views = wall_views()
    marks = np.random.default_rng(0).random(SHAPE, dtype=np.float32)
    views[2], views[3] = (
        replace(views[2], confidence=marks),
        replace(views[3], confidence=np.full(SHAPE, 0.25, np.float32)),
    )
    forward = reproject_all(views, views[2])
    layers = reassociate(views[2].truth, views, views[2], forward, units())
    np.testing.assert_array_equal(layers.confidence[2], marks)
    assert (layers.confidence[3][np.isfinite(layers.depth[3])] == 0.25).all()
    np.testing.assert_array_equal(layers.confidence[0] > 0, np.isfinite(layers.depth[0]))


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_fusing_again_is_nearer_to_the_truth_when_noise_scatters_points_over_pixels(inverse):
    views = wall_views(noise=0.2)
    settings = Fusion(method="tgv-l1", solver=Solver(iterations=500))
    once, again = (fuse(views, views[2], replace(settings, reassociate=n), inverse=inverse) for n in (0, 1))
    seen = again.observations > 0
    error = [np.abs(result.depth - views[2].truth)[seen].mean() for result in (once, again)]
    assert error[1] < 0.6 * error[0]
    np.testing.assert_array_equal(once.median, again.median)
