"""Log density of a mixture of multivariate t densities at many points.

log and exp are spelt out here, so that they run in the vector loops over the points: half of the time went into them
one by one.
"""

import numpy as np
from numba import njit

LANES = 128  # points that are asked together
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # their sum is log 2 to 1e-26
LOG2_E = 1.4426950408889634
ROUND = (
    6755399441055744.0  # 1.5 * 2^52: a small number added to it is rounded to an integer, which stands in its low bits
)
ROUND_BITS = 0x4338000000000000
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
FLOOR = -700.0  # exp of less is taken to be exp of this, 1e-304
CEILING = 1e300


@njit(cache=True, error_model="numpy", nogil=True)
def _exp(x, scratch):
    """exp of all elements, at most 0, in place: 2^e times the Taylor series of the rest, to 2 units in the
    last place.
    """
    bits, new = scratch.view(np.int64), x.view(np.int64)
    for p in range(LANES):
        x[p] = x[p] if x[p] > FLOOR else FLOOR
        scratch[p] = x[p] * LOG2_E + ROUND
    for p in range(LANES):
        e = scratch[p] - ROUND
        r = (x[p] - e * LN2_HIGH) - e * LN2_LOW
        s = 1 / 3628800 + r * (1 / 39916800 + r / 479001600)
        s = 1 / 5040 + r * (1 / 40320 + r * (1 / 362880 + r * s))
        s = 1 / 24 + r * (1 / 120 + r * (1 / 720 + r * s))
        x[p] = 1 + r * (1 + r * (1 / 2 + r * (1 / 6 + r * s)))
    for p in range(LANES):
        new[p] += bits[p] << 52


@njit(cache=True, error_model="numpy", nogil=True)
def _log(x, scratch):
    """log of all elements, normal numbers, in place: e log 2 plus the series of log((1 + s) / (1 - s)), to 2 units in
    the last place.
    """
    bits, exponent = x.view(np.int64), scratch.view(np.int64)
    for p in range(LANES):
        e = (bits[p] - ROOT_HALF_BITS) >> 52  # so that what is left lies in [sqrt(1/2), sqrt(2))
        exponent[p] = e + ROUND_BITS
        bits[p] -= e << 52
    for p in range(LANES):
        e, s = scratch[p] - ROUND, (x[p] - 1) / (x[p] + 1)
        q = s * s
        r = 1 / 15 + q * (1 / 17 + q * (1 / 19 + q / 21))
        r = 1 / 9 + q * (1 / 11 + q * (1 / 13 + q * r))
        r = 1 / 3 + q * (1 / 5 + q * (1 / 7 + q * r))
        x[p] = e * LN2_HIGH + (2 * s + (2 * s * q * r + e * LN2_LOW))


@njit(cache=True, error_model="numpy", nogil=True)
def _squares(block, shift, inverse, work, out):
    """out (LANES,): 1 + |inverse x - shift|^2, at most CEILING, for a block (d, LANES) of points; `inverse` lower
    triangular.
    """
    for p in range(LANES):
        out[p] = 1.0
    for j in range(block.shape[0]):
        start = -shift[j]
        for p in range(LANES):
            work[p] = start
        for i in range(j + 1):
            point, factor = block[i], inverse[j, i]
            for p in range(LANES):
                work[p] += factor * point[p]
        for p in range(LANES):
            out[p] += work[p] * work[p]
    for p in range(LANES):
        out[p] = out[p] if out[p] < CEILING else CEILING


@njit(cache=True, error_model="numpy", nogil=True)
def _log_sum(block, constant, exponent, shift, inverse, score, work):
    """log sum_m exp(constant_m) (1 + |inverse_m x - shift_m|^2)^(-exponent_m) of a block: (LANES,); score (m, LANES) is
    scratch.
    """
    m = constant.shape[0]
    greatest, total = np.full(LANES, -np.inf), np.zeros(LANES)
    for c in range(m):
        mine, a, b = score[c], constant[c], exponent[c]
        _squares(block, shift[c], inverse[c], work, mine)
        _log(mine, work)
        for p in range(LANES):
            mine[p] = a - b * mine[p]
            greatest[p] = max(greatest[p], mine[p])
    for c in range(m):
        mine = score[c]
        for p in range(LANES):
            mine[p] -= greatest[p]
        _exp(mine, work)
        for p in range(LANES):
            total[p] += mine[p]
    _log(total, work)
    return greatest + total


@njit(cache=True, error_model="numpy", nogil=True)
def log_mixture(x, constant, exponent, shift, inverse):
    """log sum_m exp(constant_m) (1 + |inverse_m x - shift_m|^2)^(-exponent_m) at the points x (n, d): (n,); NaN where x
    is not finite.
    """
    n, d = x.shape
    result = np.empty(n)
    block, score, work = np.zeros((d, LANES)), np.empty((constant.shape[0], LANES)), np.empty(LANES)
    for start in range(0, n, LANES):
        count = min(LANES, n - start)
        for p in range(count):
            for i in range(d):
                block[i, p] = x[start + p, i]
        found = _log_sum(block, constant, exponent, shift, inverse, score, work)
        for p in range(count):
            finite = 0.0
            for i in range(d):
                finite += 0 * block[i, p]
            result[start + p] = found[p] + finite
    return result
