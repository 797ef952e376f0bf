"""Forward projection of a depth map into another camera, nearest pixel, nearest surface wins."""

from numba import njit
import numpy as np


@njit(cache=True, error_model="numpy", nogil=True)
def splat(target, source, depth, rays, rotation, translation, intrinsics):
    """Z-buffer every valid pixel of `depth` into `target` (h, w) float32, which starts as +inf.

    source (h, w) receives the flat index of the pixel of `depth` that won. depth (H, W) float32, NaN or <= 0 where there is
    none: such a pixel is never projected. rays (3, 3) takes (column, row, 1) to the viewing ray with z = 1; rotation (3, 3)
    and translation (3,) go from the source camera to the target camera; intrinsics (3, 3) are the target's.
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

