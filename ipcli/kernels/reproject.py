"""Forward projection of a depth map into another camera, nearest pixel, nearest surface wins."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def splat(target, source, depth, rays, rotation, translation, intrinsics):
    """Z-buffer every valid pixel of `depth` into `target` (h, w) float32, which starts as +inf.

    source (h, w) receives the flat index of the pixel of `depth` that won. depth (H, W) float32, NaN or <= 0 where
    there is none: such a pixel is never projected. rays (3, 3) takes (column, row, 1) to the viewing ray with z = 1;
    rotation (3, 3) and translation (3,) go from the source camera to the target camera; intrinsics (3, 3) are the
    target's.
    """
    rows, columns = target.shape
    to_target = intrinsics @ rotation @ rays
    shift = intrinsics @ translation
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            d = np.float64(depth[i, j])
            if not d > 0:
                continue
            z = d * (to_target[2, 0] * j + to_target[2, 1] * i + to_target[2, 2]) + shift[2]
            if not z > 0:
                continue
            u = (d * (to_target[0, 0] * j + to_target[0, 1] * i + to_target[0, 2]) + shift[0]) / z
            v = (d * (to_target[1, 0] * j + to_target[1, 1] * i + to_target[1, 2]) + shift[1]) / z
            if not (-0.5 <= u < columns - 0.5 and -0.5 <= v < rows - 0.5):
                continue
            row, column = int(np.floor(v + 0.5)), int(np.floor(u + 0.5))
            if z < target[row, column]:
                target[row, column] = z
                source[row, column] = i * depth.shape[1] + j


@njit(cache=True, error_model="numpy", nogil=True)
def look_up(
    observed,
    source,
    depth,
    facing,
    seen,
    inverse_intrinsics,
    motion,
    intrinsics,
    inverse,
    reach,
    grazing,
    largest_shift,
):
    """Write what a view says of the depth of each pixel of a map, +inf where nothing, and the flat index of its pixel.

    observed (h, w) float32 and source (h, w); depth (h, w) and facing (h, w, 3), the map and its normals; seen (H, W),
    the depth map of the view; inverse_intrinsics (3, 3) of the map's camera and of the view's (2, 3, 3) stacked; motion
    (4, 4) from the map's camera to the view; intrinsics (3, 3) of the view; inverse, whether inverse depth is what is
    compared; reach, the largest difference in that quantity; grazing and largest_shift, when the tangent plane is not
    believed.
    """
    of_map, of_view = inverse_intrinsics[0], inverse_intrinsics[1]
    turn = np.ascontiguousarray(motion[:3, :3]) @ np.ascontiguousarray(of_map)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            observed[i, j] = np.inf
            z = np.float64(depth[i, j])
            rx = turn[0, 0] * j + turn[0, 1] * i + turn[0, 2]
            ry = turn[1, 0] * j + turn[1, 1] * i + turn[1, 2]
            rz = turn[2, 0] * j + turn[2, 1] * i + turn[2, 2]
            px, py, own = z * rx + motion[0, 3], z * ry + motion[1, 3], z * rz + motion[2, 3]
            if not (own > 0 and rz > 0):
                continue
            u = (intrinsics[0, 0] * px + intrinsics[0, 1] * py) / own + intrinsics[0, 2]
            v = intrinsics[1, 1] * py / own + intrinsics[1, 2]
            if not (-0.5 <= u < seen.shape[1] - 0.5 and -0.5 <= v < seen.shape[0] - 0.5):
                continue
            row, column = int(np.floor(v + 0.5)), int(np.floor(u + 0.5))
            d = np.float64(seen[row, column])
            if not d > 0:
                continue
            expected = own
            nx, ny, nz = (
                motion[0, 0] * facing[i, j, 0] + motion[0, 1] * facing[i, j, 1] + motion[0, 2] * facing[i, j, 2],
                motion[1, 0] * facing[i, j, 0] + motion[1, 1] * facing[i, j, 1] + motion[1, 2] * facing[i, j, 2],
                motion[2, 0] * facing[i, j, 0] + motion[2, 1] * facing[i, j, 1] + motion[2, 2] * facing[i, j, 2],
            )
            cx = of_view[0, 0] * column + of_view[0, 1] * row + of_view[0, 2]
            cy = of_view[1, 1] * row + of_view[1, 2]
            towards = -(nx * cx + ny * cy + nz)
            if towards > grazing:
                plane = -(nx * px + ny * py + nz * own) / towards
                if abs(plane - own) < largest_shift * own:
                    expected = plane
            q = 1 / z if inverse else z
            step = (1 / d - 1 / expected) * (expected / z) ** 2 / rz if inverse else (d - expected) / rz
            if abs(step) <= reach and q + step > 0:
                observed[i, j] = 1 / (q + step) if inverse else q + step
                source[i, j] = row * seen.shape[1] + column
