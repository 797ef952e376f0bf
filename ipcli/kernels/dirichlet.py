"""Collapsed Gibbs sampling and split-merge moves for Dirichlet process mixtures of Gaussians (Normal-Wishart base).

The base measure is S ~ Wishart(beta, psi^-1), mu | S ~ N(xi, (rho S)^-1); means and precisions are integrated out.
Clusters stand side by side along the last axis of every array: all are asked about a point in one vector loop. Slot 0
is the empty cluster, whose predictive is that of the base measure; slots 1, 2, ... hold clusters 0, 1, ... of labels.
"""

import math
from collections import namedtuple

import numpy as np
from numba import njit

LANES = 4  # slots are asked about a point in whole vectors of so many
WEAK = 1e-10  # share of a pivot that must remain when a point is taken out, or else its cluster is built anew
PRIOR = 0

# mean (d, slots); psi = L D L' by L (d, d, slots), unit lower, and inverse (d, slots), 1 / D; work (d, slots); the
# others (slots,)
Clusters = namedtuple("Clusters", "count mean lower inverse logdet constant exponent ratio work score")
# xi (d,), chol (d, d) of psi; by the number of points in a cluster, predictive (n + 2,) and marginal (n + 2,)
Base = namedtuple("Base", "xi rho beta chol predictive marginal")


@njit(cache=True, error_model="numpy", nogil=True)
def _base(xi, rho, beta, chol, alpha, n):
    """The base measure with its tables, by the number m of points in a cluster.

    predictive[m]: log of the weight (m, or alpha if empty) times the constant of the t density; marginal[m]: log
    density of m points together without the powers of |psi|.
    """
    d = xi.shape[0]
    predictive, marginal = np.empty(n + 2), np.zeros(n + 2)
    for m in range(n + 2):
        r, b = rho + m, beta + m
        constant = math.lgamma(0.5 * (b + 1)) - math.lgamma(0.5 * (b + 1 - d))
        constant -= 0.5 * d * math.log(math.pi * (r + 1) / r)
        predictive[m] = math.log(m if m > 0 else alpha) + constant
        if m < n + 1:
            marginal[m + 1] = marginal[m] + constant
    return Base(xi, rho, beta, chol, predictive, marginal)


@njit(cache=True, error_model="numpy", nogil=True)
def _allocate(d, slots):
    slots = (slots + LANES - 1) // LANES * LANES
    count, mean, work, score = np.zeros(slots, np.int64), np.zeros((d, slots)), np.zeros((d, slots)), np.zeros(slots)
    lower, inverse = np.zeros((d, d, slots)), np.ones((d, slots))
    logdet, constant, exponent, ratio = np.zeros(slots), np.full(slots, -np.inf), np.zeros(slots), np.ones(slots)
    return Clusters(count, mean, lower, inverse, logdet, constant, exponent, ratio, work, score)


@njit(cache=True, error_model="numpy", nogil=True)
def _grown(clusters):
    """The same clusters with room for twice as many."""
    old = clusters.count.shape[0]
    more = _allocate(clusters.mean.shape[0], 2 * old)
    more.count[:old], more.mean[:, :old], more.lower[:, :, :old] = clusters.count, clusters.mean, clusters.lower
    more.inverse[:, :old], more.logdet[:old], more.constant[:old] = clusters.inverse, clusters.logdet, clusters.constant
    more.exponent[:old], more.ratio[:old] = clusters.exponent, clusters.ratio
    return more


@njit(cache=True, error_model="numpy", nogil=True)
def _weigh(clusters, k, base):
    """Set what the predictive of slot k takes from its count and determinant."""
    m = clusters.count[k]
    clusters.constant[k] = base.predictive[m] - 0.5 * clusters.logdet[k]
    clusters.exponent[k] = 0.5 * (base.beta + m + 1)
    clusters.ratio[k] = (base.rho + m) / (base.rho + m + 1)


@njit(cache=True, error_model="numpy", nogil=True)
def _open(clusters, k, base):
    """Make slot k the empty cluster."""
    clusters.count[k] = 0
    clusters.logdet[k] = 0.0
    for j in range(base.xi.shape[0]):
        pivot = base.chol[j, j]
        clusters.mean[j, k] = base.xi[j]
        clusters.inverse[j, k] = 1 / (pivot * pivot)
        clusters.logdet[k] += 2 * math.log(pivot)
        for i in range(j, base.xi.shape[0]):
            clusters.lower[i, j, k] = base.chol[i, j] / pivot
    _weigh(clusters, k, base)


@njit(cache=True, error_model="numpy", nogil=True)
def _update(clusters, k, v, a):
    """L D L' + a v v' in slot k (C1 of Gill, Golub, Murray and Saunders 1974); v is spent. Whether it was safe."""
    d, growth = v.shape[0], 1.0
    lower, inverse = clusters.lower, clusters.inverse
    for j in range(d):
        p = v[j]
        c = 1 + a * p * p * inverse[j, k]
        if c < WEAK:
            return False
        growth *= c
        c = 1 / c
        inverse[j, k] *= c
        b = a * p * inverse[j, k]
        a *= c
        for i in range(j + 1, d):
            v[i] -= p * lower[i, j, k]
            lower[i, j, k] += b * v[i]
    clusters.logdet[k] += math.log(growth)
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def _add(clusters, k, x, base, v):
    """Put the point x (d,) into slot k; v (d,) is scratch."""
    r = base.rho + clusters.count[k]
    for i in range(x.shape[0]):
        v[i] = x[i] - clusters.mean[i, k]
        clusters.mean[i, k] += v[i] / (r + 1)
    clusters.count[k] += 1
    _update(clusters, k, v, r / (r + 1))
    _weigh(clusters, k, base)


@njit(cache=True, error_model="numpy", nogil=True)
def _take(clusters, k, x, base, v):
    """Take the point x out of slot k. False if rounding forbids it; the slot is then to be built anew."""
    clusters.count[k] -= 1
    r = base.rho + clusters.count[k]
    for i in range(x.shape[0]):
        v[i] = x[i] - clusters.mean[i, k]
        clusters.mean[i, k] -= v[i] / r
    if not _update(clusters, k, v, -(r + 1) / r):
        return False
    _weigh(clusters, k, base)
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def _rebuild(clusters, k, x, z, label, base, v):
    """Build slot k from the points of that label."""
    _open(clusters, k, base)
    for i in range(x.shape[0]):
        if z[i] == label:
            _add(clusters, k, x[i], base, v)


@njit(cache=True, error_model="numpy", nogil=True)
def _squares(clusters, slots, x):
    """score[k] = (x - mean)' psi^-1 (x - mean) for the first slots, a multiple of LANES."""
    score = clusters.score
    for k in range(slots):
        score[k] = 0.0
    for j in range(x.shape[0]):
        u, mean, inverse = clusters.work[j], clusters.mean[j], clusters.inverse[j]
        for k in range(slots):
            u[k] = x[j] - mean[k]
        for i in range(j):
            row, known = clusters.lower[j, i], clusters.work[i]
            for k in range(slots):
                u[k] -= row[k] * known[k]
        for k in range(slots):
            score[k] += u[k] * u[k] * inverse[k]


@njit(cache=True, error_model="numpy", nogil=True)
def _ask(clusters, slots, x, own, base):
    """Set score[k], log weight times predictive density of x (d,) given the others in the slot, and give the greatest.

    `own` is the slot that holds x itself, 0 if none does. It need not be taken out: with m others, r = rho + m and q
    the square against all of the slot, |psi of the others| = |psi| (1 - q (r + 1) / r), and the t density follows from
    the two.
    """
    slots, score = (slots + LANES - 1) // LANES * LANES, clusters.score
    _squares(clusters, slots, x)
    square = score[own]
    for k in range(slots):
        score[k] = clusters.constant[k] - clusters.exponent[k] * math.log(1 + clusters.ratio[k] * score[k])
    if own:
        m = clusters.count[own] - 1
        score[own] = -np.inf
        if m:
            shrink = math.log(max(1 - square * (base.rho + m + 1) / (base.rho + m), WEAK))
            score[own] = base.predictive[m] - 0.5 * (clusters.logdet[own] - (base.beta + m) * shrink)
    greatest = -np.inf
    for k in range(slots):
        greatest = max(greatest, score[k])
    return greatest


@njit(cache=True, error_model="numpy", nogil=True)
def _choose(clusters, slots, greatest, rng):
    """A slot drawn with probability proportional to exp(score)."""
    total = 0.0
    for k in range(slots):
        total += math.exp(clusters.score[k] - greatest)
        clusters.score[k] = total
    threshold = rng.random() * total
    k = 0
    while clusters.score[k] <= threshold and k < slots - 1:
        k += 1
    return k


@njit(cache=True, error_model="numpy", nogil=True)
def _compact(z, clusters, slots):
    """Number the clusters of the labels 0, 1, ... without gaps, in their order; the number of clusters."""
    new, k = np.empty(slots, np.int64), 0
    for slot in range(1, slots):
        new[slot] = k
        k += clusters.count[slot] > 0
    for i in range(z.shape[0]):
        z[i] = new[z[i] + 1]
    return k


@njit(cache=True, error_model="numpy", nogil=True)
def _gather(x, z, base, k):
    """The clusters of the labels, with room for some more."""
    clusters, v = _allocate(x.shape[1], k + 1 + 2 * LANES), np.empty(x.shape[1])
    for slot in range(k + 1):
        _open(clusters, slot, base)
    for i in range(x.shape[0]):
        _add(clusters, z[i] + 1, x[i], base, v)
    return clusters


@njit(cache=True, error_model="numpy", nogil=True)
def _leave(clusters, slot, x, z, i, base, v):
    """Take point i out of its slot, which is given up if that was its last."""
    label, z[i] = z[i], -1
    if clusters.count[slot] == 1:
        clusters.count[slot] = 0
        clusters.constant[slot] = -np.inf  # no point will choose it
    elif not _take(clusters, slot, x[i], base, v):
        _rebuild(clusters, slot, x, z, label, base, v)


@njit(cache=True, error_model="numpy", nogil=True)
def sweep(x, z, k, xi, rho, beta, chol, alpha, rng):
    """Neal's Algorithm 3 once over points x (n, d), labels z (n,) of k clusters in place; (new k, points moved)."""
    n, d = x.shape
    base = _base(xi, rho, beta, chol, alpha, n)
    clusters, slots, v, moved = _gather(x, z, base, k), k + 1, np.empty(d), 0
    free, gone = np.empty(n + 1, np.int64), 0  # slots given up, to be used again
    for i in range(n):
        own = z[i] + 1
        slot = _choose(clusters, slots, _ask(clusters, slots, x[i], own, base), rng)
        if slot == own or (slot == PRIOR and clusters.count[own] == 1):
            continue
        moved += 1
        _leave(clusters, own, x, z, i, base, v)
        if clusters.count[own] == 0:
            free[gone] = own
            gone += 1
        if slot == PRIOR and gone:
            gone -= 1
            slot = free[gone]
            _open(clusters, slot, base)
        elif slot == PRIOR:
            slot = slots
            slots += 1
            if slots > clusters.count.shape[0]:
                clusters = _grown(clusters)
            _open(clusters, slot, base)
        _add(clusters, slot, x[i], base, v)
        z[i] = slot - 1
    return _compact(z, clusters, slots), moved


@njit(cache=True, error_model="numpy", nogil=True)
def _log_marginal(clusters, slot, base):
    """log density of the points in the slot together, less what depends on the base alone."""
    m = clusters.count[slot]
    return base.marginal[m] - 0.5 * (base.beta + m) * clusters.logdet[slot]


@njit(cache=True, error_model="numpy", nogil=True)
def _which(clusters, x, own, forced, base, rng):
    """(side, log probability of that side) of a point between slots 1 and 2: drawn, or `forced` if that is not 0."""
    _ask(clusters, 3, x, own, base)
    a, b = clusters.score[1], clusters.score[2]
    log_total = max(a, b) + math.log1p(math.exp(-abs(a - b)))
    side = forced
    if side == 0:
        side = 1 if math.log(1 - rng.random()) < a - log_total else 2
    return side, (a if side == 1 else b) - log_total


@njit(cache=True, error_model="numpy", nogil=True)
def _members(z, i, j, rng):
    """The points other than i and j of their clusters, in random order."""
    members, m = np.empty(z.shape[0], np.int64), 0
    for p in range(z.shape[0]):
        if p != i and p != j and (z[p] == z[i] or z[p] == z[j]):
            at = int(rng.random() * (m + 1))
            members[m], members[at] = members[at], p
            m += 1
    return members[:m]


@njit(cache=True, error_model="numpy", nogil=True)
def _rescan(pair, x, members, side, target, base, v, rng):
    """A restricted scan over the members; towards the sides `target` if it holds any.

    The log probability of its outcome; NaN if rounding forbids a step, and then the move is to be rejected.
    """
    log_probability = 0.0
    for m in range(members.shape[0]):
        point, own = x[members[m]], side[m]
        side[m], log_p = _which(pair, point, own, target[m], base, rng)
        log_probability += log_p
        if side[m] != own:
            if own and not _take(pair, own, point, base, v):
                return np.nan
            _add(pair, side[m], point, base, v)
    return log_probability


@njit(cache=True, error_model="numpy", nogil=True)
def _propose(x, i, j, members, target, base, scans, rng):
    """(sides, log probability) of a split of the members between seeds i and j, drawn, or towards any `target`.

    The launch state is dealt out one by one (as Dahl 2005), in random order, before its restricted scans: it depends on
    the seeds and the members alone, so that the probability of the proposal is that of the last scan.
    """
    pair, v = _allocate(x.shape[1], 3), np.empty(x.shape[1])
    for seed, slot in ((i, 1), (j, 2)):
        _open(pair, slot, base)
        _add(pair, slot, x[seed], base, v)
    side, nowhere = np.zeros(members.shape[0], np.int64), np.zeros(members.shape[0], np.int64)
    log_q = 0.0
    for _ in range(1 + scans):
        log_q += _rescan(pair, x, members, side, nowhere, base, v, rng)
    return side, np.nan if math.isnan(log_q) else _rescan(pair, x, members, side, target, base, v, rng)


@njit(cache=True, error_model="numpy", nogil=True)
def _log_gain(x, i, j, members, side, base, log_alpha):
    """log posterior with seeds and members apart on their sides, less that with all in one cluster."""
    three, v = _allocate(x.shape[1], 4), np.empty(x.shape[1])
    for slot in range(1, 4):
        _open(three, slot, base)
    for seed, slot in ((i, 1), (j, 2)):
        _add(three, slot, x[seed], base, v)
        _add(three, 3, x[seed], base, v)
    for m in range(members.shape[0]):
        _add(three, side[m], x[members[m]], base, v)
        _add(three, 3, x[members[m]], base, v)
    a, b = three.count[1], three.count[2]
    gain = log_alpha + math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)
    for p in range(x.shape[1]):  # |psi|^(beta / 2), one a cluster, is in none of the marginals
        gain += base.beta * math.log(base.chol[p, p])
    return gain + _log_marginal(three, 1, base) + _log_marginal(three, 2, base) - _log_marginal(three, 3, base)


@njit(cache=True, error_model="numpy", nogil=True)
def _split(z, j, members, side, k):
    """Give seed j and the members on its side the label k."""
    z[j] = k
    for m in range(members.shape[0]):
        if side[m] == 2:
            z[members[m]] = k


@njit(cache=True, error_model="numpy", nogil=True)
def _merge(z, into, freed, k):
    """Give all of label `freed` the label `into`; the last of the k labels takes the place of `freed`."""
    for p in range(z.shape[0]):
        if z[p] == freed:
            z[p] = into
    for p in range(z.shape[0]):
        if z[p] == k - 1:
            z[p] = freed


@njit(cache=True, error_model="numpy", nogil=True)
def split_merge(x, z, k, xi, rho, beta, chol, alpha, moves, scans, rng):
    """Split-merge moves (Jain and Neal 2004) in place; (the new k, splits accepted, merges accepted)."""
    n, splits, merges = x.shape[0], 0, 0
    base = _base(xi, rho, beta, chol, alpha, n)
    for _ in range(moves if n > 1 else 0):
        i = int(rng.random() * n)
        j = int(rng.random() * (n - 1))
        j += j >= i
        members = _members(z, i, j, rng)
        level = math.log(1 - rng.random())
        target, gain = np.zeros(members.shape[0], np.int64), 0.0
        if z[i] != z[j]:
            for m in range(members.shape[0]):
                target[m] = 1 if z[members[m]] == z[i] else 2
            gain = _log_gain(x, i, j, members, target, base, math.log(alpha))
            if not level < -gain:  # no proposal is more probable than 1: this merge is rejected whatever its split's is
                continue
        side, log_q = _propose(x, i, j, members, target, base, scans, rng)
        if z[i] != z[j]:
            if level < log_q - gain:
                _merge(z, z[i], z[j], k)
                k, merges = k - 1, merges + 1
        elif level < _log_gain(x, i, j, members, side, base, math.log(alpha)) - log_q:
            _split(z, j, members, side, k)
            k, splits = k + 1, splits + 1
    return k, splits, merges
