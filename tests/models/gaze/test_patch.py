"""A textured plane seen by two cameras: its place to hundredths of a pixel, with an error that is what it says."""

import numpy as np
import pytest

from ipcli.models.gaze import patch

FOCAL, BASE = 300.0, 36.0  # pixels, pixels * metres: 12 cm apart
TRUE = np.array([0.04, -0.02, 0.4])  # 1 / metres: a plane at 2.5 m, turned a little


def _grey(u, v):
    """Smooth texture with structure of several sizes."""
    return 120 + 40 * np.sin(0.31 * u + 0.12 * v) + 30 * np.sin(0.13 * u - 0.4 * v + 1) + 20 * np.cos(0.7 * u + 0.2 * v)


def _pair(rng, noise, strength=1.0):
    v, u = np.indices((60, 100), dtype=float)
    ideal = np.stack([(u - 50) / FOCAL, (v - 30) / FOCAL, np.ones_like(u)], axis=-1)
    left = _grey(u, v)
    # the right picture at (u, v) shows what is at (u + d, v) in the left one, with d = base n . x of the left pixel
    n = TRUE
    source = (u + BASE * (n[2] + n[1] * ideal[..., 1] - n[0] * 50 / FOCAL)) / (1 - BASE * n[0] / FOCAL)
    right = 0.9 * _grey(source, v) + 8
    left, right = (120 + strength * (p - 120) for p in (left, right))
    pictures = [np.clip(np.rint(p + rng.normal(0, noise, p.shape)), 0, 255).astype(np.uint8) for p in (left, right)]
    rows, columns = np.mgrid[20:41, 45:66]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1)
    return (*pictures, ideal[pixels[:, 1], pixels[:, 0]], pixels)


def test_the_plane_is_found_from_a_third_of_a_pixel_away_whatever_the_gain():
    found = patch.align(*_pair(np.random.default_rng(0), 0.0), BASE, TRUE + [0, 0, 0.35 / BASE])
    assert abs(BASE * (found.normal - TRUE) @ [5 / FOCAL, 0, 1]) < 0.02  # pixels, in the middle of the patch
    assert np.abs(found.normal - TRUE).max() < 0.02


@pytest.mark.parametrize(("noise", "strength"), [(3.0, 1.0), (2.0, 0.2)])
def test_its_covariance_is_that_of_the_errors(noise, strength):
    """Where slopes are hardly more than noise too: those of one picture alone would claim half the variance."""
    squares, sizes = [], []
    for seed in range(120):
        found = patch.align(*_pair(np.random.default_rng(seed), noise, strength), BASE, TRUE + [0, 0, 0.2 / BASE])
        if found is None:  # what is left looks no more alike than pictures of different things
            continue
        off = found.normal - TRUE
        squares.append(off @ np.linalg.solve(found.covariance, off))
        middle = np.array([5 / FOCAL, 0, 1])
        sizes.append((off @ middle) ** 2 / (middle @ found.covariance @ middle))
    assert len(squares) > 100
    assert 1.8 < np.mean(squares) < 4.0  # 3 degrees of freedom
    assert 0.6 < np.mean(sizes) < 1.4  # of the disparity in the middle of the patch


@pytest.mark.parametrize("far", [1.6, -3.0])
def test_a_start_that_is_pixels_off_is_not_trusted(far):
    assert patch.align(*_pair(np.random.default_rng(0), 1.0), BASE, TRUE + [0, 0, far / BASE]) is None


def test_nothing_is_made_up_without_texture_or_with_few_pixels():
    left, right, ideal, pixels = _pair(np.random.default_rng(0), 1.0)
    noise = np.random.default_rng(1).integers(118, 123, (2, *left.shape), dtype=np.uint8)
    assert patch.align(noise[0], noise[1], ideal, pixels, BASE, TRUE) is None
    assert patch.align(left, np.full_like(right, 90), ideal, pixels, BASE, TRUE) is None
    assert patch.align(left, right, ideal[:20], pixels[:20], BASE, TRUE) is None
