"""What one fused depth map says about the points of another."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def ask(
    sums,
    votes,
    depth,
    normals,
    rays,
    motion,
    seen,
    facing,
    noise,
    confidence,
    observations,
    seen_rays,
    intrinsics,
    limits,
):
    """Count what another map says about the point of every pixel, and add up where it sees those that it confirms.

    Of the map: sums (h, w, 5) float64, to which position times precision (3), precision and confidence are added; votes
    (h, w, 2), in which those that confirm and those that look through are counted; depth (h, w), NaN where there is no
    point, and normals (h, w, 3); rays (3, 3) takes (column, row, 1) to the viewing ray with z = 1; motion (4, 4) goes
    to the other camera. Of the other: depth seen (H, W), normals facing (H, W, 3), noise of an observation, confidence,
    observations, rays, intrinsics.

    limits (tolerance, relative, cosine, grazing): both agree within so many noises or that share of the depth, if the
    cosine between their normals is not less. The other's surface is a plane at each pixel, so that rounding to pixels
    costs no depth on slanted walls, unless the cosine between its normal and the ray is below grazing.
    """
    tolerance, relative, cosine, grazing = limits
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            d = np.float64(depth[i, j])
            if not d > 0:
                continue
            px = d * (rays[0, 0] * j + rays[0, 1] * i + rays[0, 2])
            py = d * (rays[1, 0] * j + rays[1, 1] * i + rays[1, 2])
            x = motion[0, 0] * px + motion[0, 1] * py + motion[0, 2] * d + motion[0, 3]
            y = motion[1, 0] * px + motion[1, 1] * py + motion[1, 2] * d + motion[1, 3]
            z = motion[2, 0] * px + motion[2, 1] * py + motion[2, 2] * d + motion[2, 3]
            if not z > 0:
                continue
            rx, ry = x / z, y / z
            u = intrinsics[0, 0] * rx + intrinsics[0, 1] * ry + intrinsics[0, 2]
            v = intrinsics[1, 1] * ry + intrinsics[1, 2]
            if not (-0.5 <= u < seen.shape[1] - 0.5 and -0.5 <= v < seen.shape[0] - 0.5):
                continue
            row, column = int(np.floor(v + 0.5)), int(np.floor(u + 0.5))
            at = np.float64(seen[row, column])
            if not at > 0:
                continue
            nx, ny, nz = (
                np.float64(facing[row, column, 0]),
                np.float64(facing[row, column, 1]),
                np.float64(facing[row, column, 2]),
            )
            along, there = nx * rx + ny * ry + nz, at
            if abs(along) > grazing * np.sqrt(rx * rx + ry * ry + 1):
                sx = seen_rays[0, 0] * column + seen_rays[0, 1] * row + seen_rays[0, 2]
                sy = seen_rays[1, 0] * column + seen_rays[1, 1] * row + seen_rays[1, 2]
                there = at * (nx * sx + ny * sy + nz) / along
            limit = max(tolerance * noise[row, column], relative * at)
            if z - there < -limit:
                votes[i, j, 1] += 1
            if not abs(z - there) <= limit:
                continue
            mx, my, mz = normals[i, j, 0], normals[i, j, 1], normals[i, j, 2]
            turned = nx * (motion[0, 0] * mx + motion[0, 1] * my + motion[0, 2] * mz)
            turned += ny * (motion[1, 0] * mx + motion[1, 1] * my + motion[1, 2] * mz)
            turned += nz * (motion[2, 0] * mx + motion[2, 1] * my + motion[2, 2] * mz)
            if not turned >= cosine:
                continue
            worth = np.float64(confidence[row, column])
            precision = observations[row, column] * (worth / noise[row, column]) ** 2
            x, y, z = there * rx - motion[0, 3], there * ry - motion[1, 3], there - motion[2, 3]
            for c in range(3):
                sums[i, j, c] += precision * (motion[0, c] * x + motion[1, c] * y + motion[2, c] * z)
            sums[i, j, 3] += precision
            sums[i, j, 4] += worth
            votes[i, j, 0] += 1
