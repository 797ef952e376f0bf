"""The convex refinement on the sphere cap of the research notes, and the flattening of the printed scheme."""

import numpy as np
import pytest

from ipcli.inverse.regularize.operators import dot_test
from ipcli.models.brdf import evaluation, grid, parameters, refine

SIDE = 64


def cap(noise=0.1):
    """A sphere cap 16.3 px high on 64 x 64, its normals with noise, as research section 5 has it."""
    rows, columns = np.indices((SIDE, SIDE)) - (SIDE - 1) / 2
    radius = 40.0
    mask = np.hypot(rows, columns) < 32
    z = np.where(mask, np.sqrt(np.maximum(radius**2 - rows**2 - columns**2, 0)) - np.sqrt(radius**2 - 32**2), 0)
    true = grid.normals(z, mask)
    rng = np.random.default_rng(0)
    noisy = np.nan_to_num(true) + noise * rng.normal(size=true.shape)
    noisy[~mask] = [0, 0, 1]
    return mask, z, true, noisy / np.linalg.norm(noisy, axis=-1, keepdims=True)


def test_the_tilt_is_linear_and_its_adjoint_is_one():
    mask, _, _, noisy = cap()
    tilt = refine.Tilt.of(noisy, np.where(mask, 0.7, 0))
    rng = np.random.default_rng(1)
    assert (
        dot_test(tilt.linear, tilt.adjoint, rng.normal(size=(2, SIDE, SIDE)), rng.normal(size=(2, SIDE, SIDE))) < 1e-14
    )


def test_the_tilt_is_the_sine_of_the_angle_times_the_length():
    rng = np.random.default_rng(2)
    n = rng.normal(size=(1, 9, 3))
    n[..., 2] = np.abs(n[..., 2])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    g = rng.normal(size=(2, 1, 9))
    tilt = refine.Tilt.of(n, np.ones((1, 9)))
    m = np.stack([-g[0], -g[1], np.ones((1, 9))], axis=-1)
    size = np.linalg.norm(np.cross(m, n), axis=-1)
    np.testing.assert_allclose(np.linalg.norm(tilt.linear(g) + tilt.offset, axis=0), size, rtol=1e-10)


def test_a_cap_is_recovered_from_noisy_normals():
    mask, z, true, noisy = cap()
    params = parameters.Refinement(iterations=2500)
    found = refine.integrate([refine.Tilt.of(noisy, mask.astype(float))], mask, np.zeros_like(z), params)
    inner = evaluation.inside(mask)
    assert evaluation.normal_error(grid.normals(np.nan_to_num(found), mask), true, inner) < 0.11
    low, high = (
        np.diff(np.percentile(h[mask], (1, 99)))[0] for h in (found, z)
    )  # single pixels of the rim hang on noise
    assert low == pytest.approx(high, rel=0.05)


def test_the_printed_scheme_flattens_the_true_surface():
    mask, z, _, noisy = cap()
    assert np.ptp(z[mask]) == pytest.approx(16.3, abs=0.5)
    flat = refine.thesis_sweeps(z, noisy, mask, 1500)
    assert np.ptp(flat[mask]) < 5


def test_shading_bends_a_flat_prior_towards_the_truth():
    from ipcli.models.brdf.reflectance import Harmonics

    mask, z, true, _ = cap(0)
    lit = Harmonics(np.array([0.3, -0.3, 0.3, 0.5, 0, 0, 0, 0, 0]))
    picture = np.zeros(mask.shape)
    picture[mask] = lit.slopes(true[mask])[0]
    half = 0.6 * z
    params = parameters.Refinement(normal=0.1, photo=0.5, tgv=0.05, iterations=500)
    refined = refine.refine(half, grid.normals(half, mask), picture, mask, lit, params)
    before, after = (
        evaluation.normal_error(grid.normals(np.nan_to_num(h), mask), true, evaluation.inside(mask))
        for h in (half, refined)
    )
    assert after < 0.8 * before
