"""The z-buffer kernel against a loop over the projected points, and looking up against whole arrays."""

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, project, rays, transform
from ipcli.kernels.reproject import look_up, splat
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


def looked_up(depth, facing, seen, own_camera, motion, camera_of_view, inverse, reach, grazing, largest_shift):
    """What the kernel gives, by operations on whole arrays."""
    points = transform(motion, back_project(depth, own_camera))
    pixels = project(points, camera_of_view)
    inside = (np.abs(pixels[..., ::-1] + 0.5 - np.array(seen.shape) / 2) < np.array(seen.shape) / 2).all(axis=-1)
    column, row = np.moveaxis(np.where(inside[..., None], np.floor(pixels + 0.5), 0).astype(int), -1, 0)
    d, own = np.where(seen > 0, seen, np.nan)[row, column].astype(np.float64), points[..., 2]
    slope = (rays(depth.shape, own_camera) @ motion[:3, :3].T)[..., 2]  # of the depth in the view by that of the map
    normal = facing @ motion[:3, :3].T
    towards = -(normal * rays(seen.shape, camera_of_view)[row, column]).sum(axis=-1)
    plane = -(normal * points).sum(axis=-1) / towards
    believed = (towards > grazing) & (np.abs(plane - own) < largest_shift * own)
    expected = np.where(believed, plane, own)
    change = (1 / d - 1 / expected) * (expected / depth) ** 2 / slope if inverse else (d - expected) / slope
    q = (1 / depth if inverse else depth) + change
    near = inside & (slope > 0) & (np.abs(change) <= reach) & (q > 0)
    return np.where(near, 1 / q if inverse else q, np.inf), np.where(near, row * seen.shape[1] + column, -1)


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
@pytest.mark.parametrize("turn", [-0.3, 0.0, 0.2, 3.0])
@pytest.mark.parametrize("shapes", [((9, 13), (9, 13)), ((11, 7), (30, 41)), ((5, 20), (1, 20))], ids=str)
def test_look_up_is_the_geometry_of_whole_arrays(shapes, turn, inverse):
    rng = np.random.default_rng(11)
    depth, seen = (rng.uniform(1.5, 2.5, shape).astype(np.float32) for shape in shapes)
    depth[rng.random(depth.shape) < 0.1] = np.nan
    seen[rng.random(seen.shape) < 0.1] = np.nan
    facing = rng.normal(size=(*depth.shape, 3))
    facing[..., 2] = -1 - np.abs(facing[..., 2])
    facing /= np.linalg.norm(facing, axis=-1, keepdims=True)
    own, other = camera(shapes[0], 0.71), camera(shapes[1], 0.53)
    motion, limits = pose_at((0.113, -0.057, 0.21), turn), (0.3, 0.4, 0.2)
    observed, source = np.empty(depth.shape, np.float32), np.full(depth.shape, -1, np.intp)
    inverses = np.stack([np.linalg.inv(own), np.linalg.inv(other)])
    look_up(observed, source, depth, facing, seen, inverses, motion, other, inverse, *limits)
    with np.errstate(invalid="ignore", divide="ignore"):
        expected, index = looked_up(depth.astype(np.float64), facing, seen, own, motion, other, inverse, *limits)
    np.testing.assert_allclose(observed, expected, rtol=1e-6)
    np.testing.assert_array_equal(source, index)
    assert turn == 3.0 or np.isfinite(expected).any()
