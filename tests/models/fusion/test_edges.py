"""Weights of the first-order term, and what they are for: a step keeps its height, a plane its smoothness."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.parameters import Regulariser
from ipcli.models.fusion.edges import BLUR, first_order_weights, image_weights
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.parameters import Edges, Fusion
from tests.fixtures.fusion_scenes import scene


def test_a_plane_gets_the_gain_everywhere_and_a_step_the_share_of_its_height_by_hand():
    v = np.stack([np.full((6, 8), 0.5), np.full((6, 8), -0.25)]).astype(np.float32)
    rows, columns = np.indices((6, 8))
    plane = (0.5 * columns - 0.25 * rows).astype(np.float32)
    edges, count = Edges(gain=2.0, width=0.6), np.full((6, 8), 4.0)
    np.testing.assert_allclose(first_order_weights(plane, v, count, edges), 2.0, rtol=1e-5)
    step = plane + np.float32(3) * (columns >= 4)
    weights = first_order_weights(step, v, count, edges)
    np.testing.assert_allclose(weights[:, 3], 2 * 0.3 / (0.3 + 3), rtol=1e-5)  # width 0.6 / sqrt(4)
    np.testing.assert_allclose(np.delete(weights, 3, axis=1), 2.0, rtol=1e-5)


def test_the_weights_linearise_the_concave_penalty_from_above():
    # gain w log(1 + r / w) <= its value at r0 + weight(r0) (r - r0): what makes a pass lower it
    width, gain, r0, r = 0.3, 1.5, 0.8, np.linspace(0, 20, 500)
    x = np.array([[0, r0]], np.float32)
    weight = first_order_weights(x, np.zeros((2, 1, 2), np.float32), np.ones((1, 2)), Edges(gain=gain, width=width))[
        0, 0
    ]

    def penalty(height):
        return gain * width * np.log1p(height / width)

    assert (penalty(r) <= penalty(r0) + weight * (r - r0) + 1e-6).all()


def test_they_bring_a_scene_with_edges_nearer_to_its_truth():
    views = scene(outliers=0.02)
    even, weighted = (fuse(views, views[2], Fusion(edges=Edges(gain=gain)), inverse=False) for gain in (0.0, 1.5))
    errors = [np.abs(found.depth - views[2].truth).mean() for found in (even, weighted)]
    assert errors[1] < errors[0]


def test_a_gain_of_0_is_the_even_regulariser():
    views = scene(outliers=0.0)
    found = [
        fuse(views, views[2], Fusion(reassociate=0, edges=Edges(gain=gain)), inverse=False).depth for gain in (0.0, 1.5)
    ]
    np.testing.assert_array_equal(*found)  # without a first map there are no edges to go by


def test_the_image_halves_the_weight_where_it_changes_by_the_contrast_and_leaves_1_where_it_does_not():
    ramp = np.repeat(np.arange(20, 220, 5, np.uint8)[None, :, None], 30, axis=0).repeat(
        3, axis=2
    )  # 5 grey levels a pixel
    weights = image_weights(ramp, contrast=5.0)
    np.testing.assert_allclose(weights[:, 6:-6], 0.5, rtol=1e-3)
    np.testing.assert_allclose(image_weights(ramp.transpose(1, 0, 2), contrast=5.0), weights.T, rtol=1e-5)
    np.testing.assert_array_equal(image_weights(np.full((9, 9, 3), 77, np.uint8), contrast=2.0), 1)
    step = np.zeros((30, 40, 3), np.uint8)
    step[:, 20:] = 200
    across = image_weights(step, contrast=4.0)
    assert across[15].argmin() == 19
    assert across[15, 19] < 4 / (4 + 200 * 0.9 * 0.39 / BLUR)
    assert (across[:, :14] == 1).all()
    assert (across[:, 27:] == 1).all()


def on_the_wall(truth):
    """Where a true map (h, w) has the plane, affine in inverse depth, that its first and last rows have."""
    affine = np.stack([np.ones(truth.shape), *np.indices(truth.shape)], axis=-1)
    plane = affine @ np.linalg.lstsq(affine[[0, -1]].reshape(-1, 3), 1 / truth[[0, -1]].ravel(), rcond=None)[0]
    return np.isclose(1 / truth, plane, rtol=1e-3)


@pytest.mark.parametrize("method", ["l1-adapt", "tv-l1"])
def test_an_image_whose_edges_are_those_of_the_scene_brings_noisy_maps_nearer_to_the_truth_and_none_changes_nothing(
    method,
):
    views = scene(outliers=0.02, noise=0.1)
    truth = views[2].truth
    image = np.full((*truth.shape, 3), 40, np.uint8)
    image[~on_the_wall(truth)] = 200  # the ball
    settings = {
        use: Fusion(method=method, regulariser=Regulariser(alpha1=3.0), edges=Edges(image=use)) for use in (0.0, 4.0)
    }

    def error(use, image):
        found = fuse(views, replace(views[2], image=image), settings[use], inverse=False)
        return np.abs(found.depth - truth).mean()

    assert error(4.0, image) < 0.97 * error(0.0, image)
    assert error(4.0, None) == error(0.0, None) == error(0.0, image)


@pytest.mark.parametrize("weight", [0.3, 2.5])
def test_a_plane_of_equal_weights_is_a_number(weight):
    x, v = (np.random.default_rng(3).normal(size=shape).astype(np.float32) for shape in ((7, 9), (2, 7, 9)))
    number, plane = (tgv.value(x, v, Regulariser(alpha1=a)) for a in (weight, np.full((7, 9), weight, np.float32)))
    assert number == pytest.approx(plane)
