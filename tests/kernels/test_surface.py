"""The kernel of normals against whole-array differences."""

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project
from ipcli.kernels import surface as kernels
from tests.fixtures.fusion_scenes import camera


def twin(depth, intrinsics):
    """Cross products of the tangents along both axes, turned to face the camera."""
    points = back_project(depth.astype(np.float64), intrinsics)
    n = np.cross(tangent(points, 0), tangent(points, 1))
    with np.errstate(invalid="ignore"):
        n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return n * np.where((n * points).sum(axis=-1, keepdims=True) > 0, -1, 1)


def tangent(points, axis):
    """The mean of the one-sided differences; the shorter one beside a gap or where they differ by more than a factor of
    two.
    """
    step = np.diff(points, axis=axis)
    gap = np.full_like(np.take(points, [0], axis=axis), np.nan)
    after, before = np.concatenate([step, gap], axis=axis), np.concatenate([gap, step], axis=axis)
    long_after, long_before = ((d * d).sum(axis=-1, keepdims=True) for d in (after, before))
    both = (long_after < 4 * long_before) & (long_before < 4 * long_after)
    shorter = np.where((long_after < long_before) | np.isnan(long_before), after, before)
    return np.where(both, (after + before) / 2, shorter)


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (2, 2), (23, 31)], ids=str)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("roughness", [0.001, 0.3])
def test_normals_are_cross_products_of_edge_keeping_tangents(shape, dtype, roughness):
    rng = np.random.default_rng(3)
    depth = (2 + np.linspace(0, 1, shape[1]) + rng.normal(0, roughness, shape)).astype(dtype)
    depth[rng.random(shape) < 0.15] = np.nan
    k = camera(shape, 1.1)
    expected = twin(depth, k)
    out = np.full((*shape, 3), -7, np.float32)
    for top, bottom in [(0, shape[0] // 2), (shape[0] // 2, shape[0])]:
        kernels.normals(out, depth, np.linalg.inv(k), top, bottom)
    np.testing.assert_allclose(out, expected, atol=2e-5)
