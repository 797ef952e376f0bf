"""Matching kernels against plain NumPy."""

import numpy as np

from ipcli.kernels import matching


def scene(seed, n=60, m=70):
    rng = np.random.default_rng(seed)
    left, right = rng.uniform(0, 100, (n, 2)), rng.uniform(0, 100, (m, 2))
    a, b = rng.integers(0, 60, (n, 128), dtype=np.uint8), rng.integers(0, 60, (m, 128), dtype=np.uint8)
    right[:30, 1], b[:30] = (
        left[:30, 1] + rng.uniform(-1, 1, 30),
        np.minimum(a[:30] + rng.integers(0, 3, (30, 128)), 255),
    )
    right[:30, 0] = left[:30, 0] - rng.uniform(1, 20, 30)
    return left, right, a, b


def plain(allowed, a, b, ratio, worst):
    distance = np.square(a[:, None].astype(int) - b[None].astype(int)).sum(axis=2)
    match = np.full(len(a), -1)
    for i in range(len(a)):
        inside = np.flatnonzero(allowed[i] & (distance[i] <= worst))
        if len(inside):
            order = inside[np.argsort(distance[i, inside], kind="stable")]
            rest = np.sort(distance[i, allowed[i]])
            second = rest[1] if len(rest) > 1 else 2 * worst + 2
            if distance[i, order[0]] <= ratio * min(second, 2 * worst + 2):
                match[i] = order[0]
    return match


def test_in_band_is_the_plain_search():
    for seed in range(4):
        left, right, a, b = scene(seed)
        order = np.argsort(right[:, 1], kind="stable")
        disparity = left[:, None, 0] - right[None, :, 0]
        allowed = (np.abs(left[:, None, 1] - right[None, :, 1]) <= 2) & (disparity >= 0.5) & (disparity <= 40)
        found, _ = matching.in_band(left, right, a, b, order, 2.0, 0.5, 40.0, 0.64, 80000)
        assert (found == plain(allowed, a, b, 0.64, 80000)).all()
        assert (found >= 0).sum() >= 25


def test_near_is_the_plain_search():
    for seed in range(4):
        expected, features, a, b = scene(seed)
        order = np.argsort(features[:, 1], kind="stable")
        radius = np.full(len(expected), 25.0)
        allowed = np.linalg.norm(expected[:, None] - features[None], axis=2) <= 25
        found, distance = matching.near(expected, features, a, b, order, radius, 0.81, 80000)
        assert (found == plain(allowed, a, b, 0.81, 80000)).all()
        hit = found >= 0
        assert (distance[hit] == np.square(a[hit].astype(int) - b[found[hit]].astype(int)).sum(axis=1)).all()


def test_what_is_not_known_matches_nothing():
    left, right, a, b = scene(9)
    left[:] = np.nan
    order = np.argsort(right[:, 1], kind="stable")
    found, _ = matching.in_band(left, right, a, b, order, 2.0, 0.5, 40.0, 0.64, 80000)
    assert (found == -1).all()
