"""Log density of a mixture of multivariate t densities at many points."""

import math

from numba import njit
import numpy as np

LANES = 64  # points that are asked together


@njit(cache=True, error_model="numpy", nogil=True)
def _squares(block, location, inverse, work, out):
    """out (LANES,): |inverse (x - location)|^2 for a block (d, LANES) of points, `inverse` lower triangular."""
    d = block.shape[0]
    for p in range(LANES):
        out[p] = 0.0
    for j in range(d):
        for p in range(LANES):
            work[p] = 0.0
        for i in range(j + 1):
            point, factor, centre = block[i], inverse[j, i], location[i]
            for p in range(LANES):
                work[p] += factor * (point[p] - centre)
        for p in range(LANES):
            out[p] += work[p] * work[p]


@njit(cache=True, error_model="numpy", nogil=True)
def log_mixture(x, constant, exponent, location, inverse):
    """log sum_m exp(constant_m) (1 + |inverse_m (x - location_m)|^2)^(-exponent_m) at the points x (n, d): (n,)."""
    n, d = x.shape
    m = constant.shape[0]
    result = np.empty(n)
    block, work, score = np.zeros((d, LANES)), np.empty(LANES), np.empty((m, LANES))
    for start in range(0, n, LANES):
        count = min(LANES, n - start)
        for p in range(count):
            for i in range(d):
                block[i, p] = x[start + p, i]
        greatest = np.full(LANES, -np.inf)
        for c in range(m):
            _squares(block, location[c], inverse[c], work, score[c])
            for p in range(LANES):
                score[c, p] = constant[c] - exponent[c] * math.log1p(score[c, p])
                greatest[p] = max(greatest[p], score[c, p])
        total = np.zeros(LANES)
        for c in range(m):
            for p in range(LANES):
                total[p] += math.exp(score[c, p] - greatest[p])
        for p in range(count):
            result[start + p] = greatest[p] + math.log(total[p])
    return result
