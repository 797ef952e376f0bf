"""The TGV solver against exact optima, closed forms and the symmetries of its functional."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Observations, SquaredDeviations
from ipcli.inverse.regularize.operators import (
    gradient,
    gradient_adjoint,
    symmetrised_gradient,
    symmetrised_gradient_adjoint,
)
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.inverse.regularize.pdhg import pdhg
from ipcli.inverse.regularize.proximal import project_balls
from tests.fixtures.cone_program import minimum

TGV, TV = Regulariser(), Regulariser(order=1)
LAM = 0.4
LONG = Solver(tolerance=0.0, iterations=6000, check=250, relaxation=1.9, primal_weight=3.0)


@cache
def small():
    """Three noisy, incomplete observations of a ramp with a step, their weights, and a hole that none of them sees."""
    rng = np.random.default_rng(11)
    rows, columns = np.indices((7, 9))
    layers = (0.3 * columns - 0.2 * rows + 3.0 * (columns > 4) + rng.laplace(0, 0.8, (3, 7, 9))).astype(np.float32)
    layers[rng.random(layers.shape) < 0.15] = np.nan
    layers[:, 2:4, 5:7] = np.nan
    return layers, rng.choice(np.float32([0.5, 1, 2]), layers.shape)


@cache
def exact(order):
    layers, weights = small()
    return minimum(layers, LAM * weights, 1.0, 2.0, order)


def absolute(layers, weights=None, scale=LAM):
    return AbsoluteDeviations(Observations.of(layers, weights), np.full(layers.shape[1:], scale, np.float32))


def solved(fidelity, bounds, regulariser=TGV, solver=LONG, start=None):
    """The iterate after the solver, and its looks."""
    iterate = tgv.Iterate.at(np.full(fidelity.scale.shape, np.mean(bounds)) if start is None else start)
    return iterate, tgv.minimise(fidelity, regulariser, iterate, bounds, solver)


def solve_small(order=2, **change):
    layers, weights = small()
    fidelity = absolute(layers, weights)
    return solved(fidelity, fidelity.data.bounds, Regulariser(order=order), replace(LONG, **change))


@pytest.mark.parametrize("order", [1, 2])
def test_the_energy_is_the_optimum_of_the_cone_program(order):
    _, looks = solve_small(order)
    assert looks[-1].energy == pytest.approx(exact(order)[0], rel=1e-4)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("relaxation", [1.0, 1.9])
def test_the_restricted_gap_bounds_the_distance_to_the_optimum_at_every_look(order, relaxation):
    optimum = exact(order)[0]
    _, looks = solve_small(order, check=10, iterations=2000, relaxation=relaxation)
    for look in looks:
        assert look.energy >= optimum * (1 - 1e-6)
        assert look.energy * look.gap >= look.energy - optimum - 1e-5 * optimum, look
    assert looks[-1].gap < 5e-3 < looks[0].gap  # and is not just large


def test_the_bound_holds_for_duals_that_are_far_from_those_of_tgv():
    """Those of TV with q = 0 certify the optimum of TV, which is higher: their slack p - E^T q has to be paid for."""
    layers, weights = small()
    fidelity, (tv, _) = absolute(layers, weights), solve_small(order=1)
    best, _ = solve_small()
    free = tv.bound(fidelity, TV, *fidelity.data.bounds)
    assert free > exact(2)[0] * 1.05
    tv.v[:] = best.v
    assert tv.bound(fidelity, TGV, *fidelity.data.bounds) <= exact(2)[0]


def test_the_solver_stops_on_the_gap_and_below_the_ceiling_only():
    _, looks = solve_small(tolerance=1e-2, check=10)
    assert looks[-1].gap <= 1e-2
    assert all(look.gap > 1e-2 for look in looks[:-1])
    layers, weights = small()
    fidelity = absolute(layers, weights)
    iterate = tgv.Iterate.at(np.zeros((7, 9)))
    ceiling = exact(2)[0] * (1 + 5e-4)
    looks = tgv.minimise(
        fidelity, TGV, iterate, fidelity.data.bounds, replace(LONG, tolerance=0.5, check=10), ceiling=ceiling
    )
    assert looks[-1].energy <= ceiling < looks[-2].energy
    assert looks[-2].gap < 0.5


def test_algorithm_4_3_with_k_dual_images_meets_the_fast_solver_at_the_same_energy():
    """z = (x, v1, v2); the duals are p, q and one image for each of the K deviations, clipped at its weight."""
    layers, weights = small()
    seen = np.isfinite(layers)
    data, bound = np.where(seen, layers, 0).astype(float), LAM * np.where(seen, weights, 0)
    exists = np.ones((2, 7, 9))
    exists[0, :, -1] = exists[1, -1] = 0

    def forward(z):
        return np.concatenate(
            [(gradient(z[0]) - z[1:]) * exists, symmetrised_gradient(z[1:]), np.repeat(z[:1], 3, axis=0)]
        )

    def adjoint(y):
        p = y[:2] * exists
        return np.concatenate([[gradient_adjoint(p) + y[5:].sum(axis=0)], symmetrised_gradient_adjoint(y[2:5]) - p])

    def prox_conjugate(y, sigma):
        p, q = project_balls(y[:2], 1.0, (1, 1)), project_balls(y[2:5], 2.0, (1, 1, 2))
        return np.concatenate([p, q, np.clip(y[5:] - sigma * data, -bound, bound)])

    step = 0.99 / np.sqrt(12 + 3)
    z, _ = pdhg(
        forward,
        adjoint,
        lambda z, tau: z,
        prox_conjugate,
        np.zeros((3, 7, 9)),
        np.zeros((8, 7, 9)),
        tau=step,
        sigma=step,
        iterations=8000,
        relaxation=1.9,
    )
    reference = tgv.value(z[0].astype(np.float32), z[1:].astype(np.float32), TGV) + (bound * np.abs(z[0] - data)).sum()
    _, looks = solve_small()
    assert abs(looks[-1].energy - reference) <= looks[-1].energy * max(looks[-1].gap, 1e-4)
    assert reference == pytest.approx(exact(2)[0], rel=1e-3)


@pytest.mark.parametrize("number", [1, 2, 3, 5])
@pytest.mark.parametrize("order", [1, 2])
def test_blocks_of_rows_on_threads_give_the_bits_of_the_whole(monkeypatch, number, order):
    rng = np.random.default_rng(2)
    layers = rng.normal(size=(4, 171, 23)).astype(np.float32)
    layers[rng.random(layers.shape) < 0.2] = np.nan
    fidelity, results = absolute(layers), []
    for count in (1, number):
        monkeypatch.setenv("NUMBA_NUM_THREADS", str(count))
        iterate = tgv.Iterate.at(np.zeros((171, 23)))
        for relaxations in ([1.9] * 37 + [1.0], [1.3] * 16):
            iterate.advance(fidelity, Regulariser(order=order), LONG, relaxations)
        results.append([*iterate.planes, iterate.energy(fidelity, TGV), iterate.bound(fidelity, TGV, -4, 4)])
    for one, other in zip(*results, strict=True):
        np.testing.assert_array_equal(one, other)


def affine(shape, a=1.0, b=0.25, c=-0.5):
    """Values and slopes that float32 holds exactly."""
    rows, columns = np.indices(shape)
    slopes = np.stack([np.full(shape, b), np.full(shape, c)]).astype(np.float32)
    return (a + b * columns + c * rows).astype(np.float32), slopes


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (8, 11)], ids=str)
def test_tgv_of_an_affine_image_and_tv_of_a_constant_are_zero_up_to_the_border(shape):
    x, slopes = affine(shape)
    assert tgv.value(x, slopes, TGV) == 0
    assert tgv.value(np.full(shape, 3, np.float32), 0 * slopes, TV) == 0
    assert tgv.value(x, 0 * slopes, TV) > 0


@pytest.mark.parametrize("shape", [(1, 15), (15, 1), (12, 17)], ids=str)
def test_an_affine_image_is_its_own_fusion_even_across_a_hole(shape):
    x, _ = affine(shape)
    layers = np.stack([x, x + 0.5, x - 0.5])
    layers[:, 0 if shape[0] < 8 else slice(3, 8), 0 if shape[1] < 8 else slice(5, 9)] = np.nan
    if shape[0] < 8 or shape[1] < 8:
        layers = np.stack([x, x + 0.5, x - 0.5])
        layers.reshape(3, -1)[:, 5:9] = np.nan
    fidelity = absolute(layers)
    iterate, looks = solved(fidelity, fidelity.data.bounds)
    np.testing.assert_allclose(iterate.x, x, atol=2e-3)
    assert looks[-1].energy == pytest.approx(LAM * np.isfinite(layers[0]).sum(), rel=1e-4)  # the data's own spread


@settings(max_examples=30)
@given(st.floats(-50, 50, width=32), st.integers(0, 99))
def test_the_value_is_homogeneous(c, seed):
    rng = np.random.default_rng(seed)
    x, v = rng.normal(size=(6, 7)).astype(np.float32), rng.normal(size=(2, 6, 7)).astype(np.float32)
    c = np.float32(c)
    assert tgv.value(c * x, c * v, TGV) == pytest.approx(abs(c) * tgv.value(x, v, TGV), rel=1e-4)


def test_the_solution_scales_with_the_data():
    layers, weights = small()
    for factor in (-1, 64):
        fidelity = absolute(np.float32(factor) * layers, weights)
        solver = replace(LONG, primal_weight=LONG.primal_weight / abs(factor))
        iterate, looks = solved(fidelity, fidelity.data.bounds, solver=solver)
        assert looks[-1].energy == pytest.approx(abs(factor) * exact(2)[0], rel=2e-4)


def test_with_the_automatic_step_ratio_the_iteration_commutes_with_a_change_of_unit():
    layers, weights = small()
    fidelity, solver = absolute(layers, weights), replace(LONG, iterations=500, primal_weight=0.0)
    start, found = np.nan_to_num(fidelity.data.median()), []
    for unit in (1, 1024):  # a power of two rounds alike
        iterate = tgv.Iterate.at(unit * start)
        bounds = tuple(unit * bound for bound in fidelity.data.bounds)
        looks = tgv.minimise(absolute(np.float32(unit) * layers, weights), TGV, iterate, bounds, solver)
        found.append((iterate.x / unit, [look.energy / unit for look in looks], [look.gap for look in looks]))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-4, atol=1e-4)


def turned(layers, weights, how):
    return [np.ascontiguousarray(how(a)) for a in (layers, weights)]


@pytest.mark.parametrize("regulariser", [TGV, TV], ids=["TGV", "TV"])
def test_the_iteration_commutes_with_transposing_the_image(regulariser):
    layers, weights = small()
    start, solver = np.zeros((7, 9)), replace(LONG, iterations=300)
    straight, _ = solved(absolute(layers, weights), (-9, 9), regulariser, solver, start)
    across, _ = solved(
        absolute(*turned(layers, weights, lambda a: a.transpose(0, 2, 1))), (-9, 9), regulariser, solver, start.T
    )
    np.testing.assert_allclose(across.x.T, straight.x, atol=2e-4)
    np.testing.assert_allclose(across.v[::-1].transpose(0, 2, 1), straight.v, atol=2e-4)


def test_on_a_line_flipping_the_data_flips_the_solution_and_keeps_the_energy():
    layers, weights = (a[:, :1] for a in small())
    optimum = minimum(layers, LAM * weights, 1.0, 2.0)[0]
    images, solver = [], replace(LONG, iterations=30000, check=2000, primal_weight=10)
    for how in (lambda a: a, lambda a: a[..., ::-1]):
        flipped = turned(layers, weights, how)
        assert minimum(flipped[0], LAM * flipped[1], 1.0, 2.0)[0] == pytest.approx(optimum, rel=1e-6)
        fidelity = absolute(*flipped)
        iterate, looks = solved(fidelity, fidelity.data.bounds, solver=solver)
        assert looks[-1].energy == pytest.approx(optimum, rel=1e-4)
        images.append(how(iterate.x[None])[0])
    np.testing.assert_allclose(*images, atol=1e-2)


TURNS = {
    "flip x": lambda a: a[..., ::-1],
    "flip y": lambda a: a[:, ::-1],
    "quarter turn": lambda a: np.rot90(a, 1, (1, 2)),
}


@pytest.mark.parametrize("how", TURNS.values(), ids=TURNS)
def test_flips_and_quarter_turns_change_the_energy_by_the_discretisation_only(how):
    """Forward differences look right and down: flipped, the isotropic norm pairs other ones. 3 % on 7 x 9 pixels."""
    layers, weights = turned(*small(), how)
    fidelity = absolute(layers, weights)
    energy = solved(fidelity, fidelity.data.bounds)[1][-1].energy
    assert energy == pytest.approx(exact(2)[0], rel=0.03)


@pytest.mark.parametrize("rows", [1, 5])
def test_rof_of_a_step_loses_contrast_by_the_closed_form(rows):
    """n columns a side and K observations of weight lambda: each side moves by alpha1 / (lambda K n)."""
    n, lam, height, k = 8, 0.1, 4.0, 2
    step = np.where(np.arange(2 * n) < n, 0, height) + np.zeros((rows, 1))
    layers = np.stack([step + 0.5, step - 0.5]).astype(np.float32)
    fidelity = SquaredDeviations.of(Observations.of(layers), np.full(step.shape, lam, np.float32))
    regulariser = Regulariser(order=1, alpha1=1.5)
    iterate, looks = solved(fidelity, (-1.0, 5.0), regulariser, replace(LONG, iterations=3000))
    loss = 1.5 / (lam * k * n)
    np.testing.assert_allclose(iterate.x, np.where(step > 0, height - loss, loss), atol=2e-3)
    assert looks[-1].gap < 1e-4


def disc(radius, centre, shape=(48, 64)):
    rows, columns = np.indices(shape)
    return (rows - centre[0]) ** 2 + (columns - centre[1]) ** 2 <= radius**2


SMALL_DISC, LARGE_DISC = disc(3.3, (24, 10)), disc(11.3, (24, 40))  # they die at lambda = 2 / radius: 0.61 and 0.18


def tv_l1(image, scale):
    data = Observations.of(image[None].astype(np.float32))
    fidelity = AbsoluteDeviations(data, np.broadcast_to(np.float32(scale), image.shape).copy())
    start = np.full(image.shape, np.median(image))
    return solved(fidelity, (image.min(), image.max()), TV, replace(LONG, iterations=2500), start)[0].x


@pytest.mark.parametrize(("small_contrast", "large_contrast"), [(1.0, 1.0), (8.0, 0.5), (0.5, 8.0)])
def test_tv_l1_keeps_discs_by_their_size_and_not_by_their_contrast(small_contrast, large_contrast):
    """Chan and Esedoglu 2005; thesis 4.5.1. In between the critical values the large disc alone survives, at full
    contrast.
    """
    image = small_contrast * SMALL_DISC + large_contrast * LARGE_DISC
    both, one, none = (tv_l1(image, lam) for lam in (1.2, 0.35, 0.1))
    assert both[24, 10] == pytest.approx(small_contrast, rel=0.02)
    assert both[24, 40] == pytest.approx(large_contrast, rel=0.02)
    assert abs(one[24, 10]) < 0.02 * small_contrast
    assert one[24, 40] == pytest.approx(large_contrast, rel=0.02)
    assert np.abs(none).max() < 0.03 * max(small_contrast, large_contrast)
    core, outside = disc(9.0, (24, 40)), ~disc(12.5, (24, 40)) & ~disc(5.0, (24, 10))
    np.testing.assert_allclose(one[core], large_contrast, rtol=0.02)
    np.testing.assert_allclose(one[outside], 0, atol=0.02 * large_contrast)


def test_a_higher_confidence_around_a_small_disc_keeps_it_where_the_even_one_would_not():
    """Figure 4.1, second row."""
    scale = np.where(disc(6.0, (24, 10)), 1.2, 0.35)
    kept = tv_l1(1.0 * SMALL_DISC + LARGE_DISC, scale)
    assert kept[24, 10] == pytest.approx(1, rel=0.02)
    assert kept[24, 40] == pytest.approx(1, rel=0.02)
