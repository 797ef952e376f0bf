"""Truncated reprojection errors of many poses of a rig at once, as RANSAC scores them."""

from __future__ import annotations

import numpy as np
from numba import njit

NEAREST = 1e-6  # depth below which a point is behind its camera


@njit(cache=True, nogil=True)
def msac(poses, cams, intrinsics, points, pixels, limit):
    """Costs (m,) of poses (m, 4, 4), and how many points (m,) fit each.

    A point's error is the mean of its squared errors over the cameras that see it (3.3); it costs at most `limit`
    (pixels^2), and just that behind a camera that sees it. `cams` (c, 4, 4): cam_from_rig; `intrinsics` (c, 4): fx, fy,
    cx, cy; `pixels` (c, n, 2), NaN where not seen.
    """
    costs, fitting = np.zeros(len(poses)), np.zeros(len(poses), np.int64)
    inside = np.empty(3)
    for m in range(len(poses)):
        for n in range(len(points)):
            for a in range(3):
                inside[a] = poses[m, a, 3]
                for b in range(3):
                    inside[a] += poses[m, a, b] * points[n, b]
            total, seen = 0.0, 0
            for c in range(len(cams)):
                if np.isnan(pixels[c, n, 0]):
                    continue
                seen += 1
                z = cams[c, 2, 3]
                x, y = cams[c, 0, 3], cams[c, 1, 3]
                for b in range(3):
                    x += cams[c, 0, b] * inside[b]
                    y += cams[c, 1, b] * inside[b]
                    z += cams[c, 2, b] * inside[b]
                if z <= NEAREST:
                    total = np.inf
                    break
                du = intrinsics[c, 0] * x / z + intrinsics[c, 2] - pixels[c, n, 0]
                dv = intrinsics[c, 1] * y / z + intrinsics[c, 3] - pixels[c, n, 1]
                total += du * du + dv * dv
            error = total / max(seen, 1)
            if error < limit:
                fitting[m] += 1
                costs[m] += error
            else:
                costs[m] += limit
    return costs, fitting
