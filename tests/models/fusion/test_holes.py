"""Holes of known scenes, and the background interpolation against the loops of the KITTI development kit."""

import hypothesis.extra.numpy as nps
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ipcli.geometry.surface import normals
from ipcli.inverse.regularize.fidelity import Observations
from ipcli.models.fusion.holes import (
    SEEN,
    UNBELIEVED,
    UNSEEN,
    fill_holes,
    interpolate_background,
    normals_of_filled,
    support,
)
from tests.fixtures.fusion_scenes import camera

NAN = np.nan


def development_kit(disparity):
    """interpolateBackground of the KITTI stereo development kit, loop by loop; -1 stands for invalid there."""
    d = np.where(np.isfinite(disparity), disparity, -1)
    height, width = d.shape
    for v in range(height):
        count = 0
        for u in range(width):
            if d[v, u] < 0:
                count += 1
                continue
            if count >= 1:
                u1, u2 = u - count, u - 1
                if u1 > 0 and u2 < width - 1:
                    d[v, u1 : u2 + 1] = min(d[v, u1 - 1], d[v, u2 + 1])
            count = 0
        for u in range(width):  # extrapolate to the left
            if d[v, u] >= 0:
                d[v, :u] = d[v, u]
                break
        for u in reversed(range(width)):  # and to the right
            if d[v, u] >= 0:
                d[v, u + 1 :] = d[v, u]
                break
    for u in range(width):
        for v in range(height):  # to the top
            if d[v, u] >= 0:
                d[:v, u] = d[v, u]
                break
        for v in reversed(range(height)):  # and to the bottom
            if d[v, u] >= 0:
                d[v + 1 :, u] = d[v, u]
                break
    return np.where(d < 0, np.nan, d)


maps = nps.arrays(
    np.float32, nps.array_shapes(min_dims=2, max_dims=2, max_side=7), elements=st.integers(0, 9) | st.just(np.nan)
)


@given(maps)
def test_background_interpolation_is_that_of_the_kitti_development_kit(disparity):
    assume(np.isfinite(disparity).any())
    filled, kit = interpolate_background(disparity), development_kit(disparity)
    reached = np.isfinite(kit)  # the kit leaves empty rows between full ones
    np.testing.assert_array_equal(filled[reached], kit[reached])
    assert np.isfinite(filled).all()
    empty = ~reached.any(axis=1)
    for row in np.flatnonzero(empty):  # here they take the row above
        np.testing.assert_array_equal(filled[row], filled[row - 1])


def test_nothing_stays_nothing():
    assert np.isnan(interpolate_background(np.full((3, 4), np.nan))).all()


def test_support_counts_what_lies_near_and_not_what_there_is():
    x = np.array([[0.0, 0, 0, 0]], np.float32)
    layers = np.array([[[1.0, 9, NAN, -9]], [[9.0, NAN, NAN, -4]]], np.float32)
    found = support(x, Observations.of(layers), believed=4.0)
    assert found.tolist() == [[SEEN, UNBELIEVED, UNSEEN, SEEN]]


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_a_hole_between_two_walls_gets_the_far_one(inverse):
    """Near wall, hole that the regulariser bridged, far wall; the hole at the border gets the only neighbour."""
    depth = np.tile(np.array([2, 2, 2.5, 3, 3.5, 4, 4, 4.5], np.float32), (3, 1))
    filled = np.tile(np.array([0, 0, 1, 1, 2, 0, 0, 1], np.uint8), (3, 1))
    found = fill_holes(depth, filled, 10.0, inverse=inverse)
    np.testing.assert_allclose(found, np.tile([2, 2, 4, 4, 4, 4, 4, 4], (3, 1)), rtol=1e-6)


def test_a_background_that_is_too_far_behind_is_another_scene():
    depth = np.array([[2, 2.5, 3, 9]], np.float32)
    filled = np.array([[0, 1, 1, 0]], np.uint8)
    np.testing.assert_array_equal(fill_holes(depth, filled, 6.2, inverse=False), [[2, 2.5, 9, 9]])
    np.testing.assert_array_equal(fill_holes(depth, filled, 5.0, inverse=False), depth)


def test_an_empty_row_or_column_and_an_empty_map():
    depth = np.array([[1, 5, 2], [1, 1, 1], [3, 5, 4]], np.float32)
    filled = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
    found = fill_holes(depth, filled, 100.0, inverse=False)
    np.testing.assert_array_equal(found, [[1, 2, 2], [1, 2, 2], [3, 4, 4]])  # the empty row takes the one above
    np.testing.assert_array_equal(fill_holes(depth, np.ones_like(filled), 100.0, inverse=False), depth)
    nothing = np.full_like(depth, NAN)
    np.testing.assert_array_equal(fill_holes(nothing, np.ones_like(filled), 1.0, inverse=True), nothing)


depths = nps.arrays(np.float32, nps.array_shapes(min_dims=2, max_dims=2, max_side=7), elements=st.integers(1, 9))


@given(depths, st.integers(0, 2**32 - 1), st.booleans())
def test_what_is_seen_stays_holes_get_what_is_seen_and_mirrors_do_not_matter(depth, seed, inverse):
    filled = np.random.default_rng(seed).integers(0, 3, depth.shape).astype(np.uint8)
    found = fill_holes(depth, filled, 100.0, inverse=inverse)
    np.testing.assert_array_equal(found[filled == SEEN], depth[filled == SEEN])
    assert (
        not (filled == SEEN).any() or np.isclose(found[..., None], depth[filled == SEEN], rtol=1e-6).any(axis=-1).all()
    )
    mirrored = fill_holes(depth[:, ::-1], filled[:, ::-1], 100.0, inverse=inverse)
    np.testing.assert_array_equal(mirrored[:, ::-1], found)


def test_normals_are_those_of_what_stands_there():
    """A plane that faces the camera with a hole whose old normals were tilted."""
    depth, intrinsics = np.full((5, 6), 2.0, np.float32), camera((5, 6))
    tilted = np.tile(np.array([0.6, 0, -0.8], np.float32), (5, 6, 1))
    filled = np.zeros((5, 6), np.uint8)
    filled[2, 3] = UNSEEN
    found = normals_of_filled(tilted, depth, filled, intrinsics)
    np.testing.assert_allclose(found[2, 3], [0, 0, -1], atol=1e-6)
    np.testing.assert_array_equal(found[filled == SEEN], tilted[filled == SEEN])
    np.testing.assert_array_equal(found[2, 3], normals(depth, intrinsics)[2, 3].astype(np.float32))
