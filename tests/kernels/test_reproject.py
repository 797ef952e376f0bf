"""The z-buffer kernel against a loop over the projected points."""

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, project, transform
from ipcli.kernels.reproject import splat
from tests.fixtures.fusion_scenes import camera, pose_at


def z_buffer(shape, points, intrinsics):
    """Nearest depth and flat index of its point for every pixel, one point after the other."""
    depth, source = np.full(shape, np.inf), np.full(shape, -1)
    for index, (point, pixel) in enumerate(zip(points, project(points, intrinsics), strict=True)):
        if np.isfinite(pixel).all():
            column, row = np.floor(pixel + 0.5).astype(int)
            if 0 <= row < shape[0] and 0 <= column < shape[1] and point[2] < depth[row, column]:
                depth[row, column], source[row, column] = point[2], index
    return depth, source


@pytest.mark.parametrize(
    ("shape", "target_shape"), [((9, 13), (9, 13)), ((30, 41), (11, 7)), ((1, 20), (5, 20)), ((17, 1), (3, 3))]
)
@pytest.mark.parametrize("turn", [-0.3, 0.0, 0.4, 3.0])
def test_splat_is_a_z_buffer_over_all_valid_pixels(shape, target_shape, turn):
    rng = np.random.default_rng(7)
    depth = rng.uniform(0.5, 3, shape).astype(np.float32)
    depth[rng.random(shape) < 0.2] = np.nan
    depth[rng.random(shape) < 0.1] = -1
    source_camera, target_camera = camera(shape, 0.71), camera(target_shape, 0.53)
    motion = pose_at((0.113, -0.057, 0.21), turn)
    target, source = np.full(target_shape, np.inf, np.float32), np.full(target_shape, -1, np.intp)
    rays = np.linalg.inv(source_camera)
    splat(target, source, depth, rays, motion[:3, :3].copy(), motion[:3, 3].copy(), target_camera)
    points = transform(motion, back_project(np.where(depth > 0, depth, np.nan).astype(np.float64), source_camera))
    expected, winner = z_buffer(target_shape, points.reshape(-1, 3), target_camera)
    np.testing.assert_allclose(target, expected, rtol=1e-6)
    np.testing.assert_array_equal(source, winner)
    assert turn == 3.0 or np.isfinite(expected).any()
