"""Data terms: medians and means of incomplete observations, energies, proximal maps and lower bounds, by
brute force.
"""

from dataclasses import dataclass

import hypothesis.extra.numpy as nps
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcli.inverse.regularize.fidelity import AbsoluteDeviations, Anchored, Observations, SquaredDeviations

SHAPE = (3, 4)
GRID = np.linspace(-9, 9, 7201)  # a step of 1/400
values = st.integers(-32, 32).map(lambda n: n / 4)


@st.composite
def observations(draw):
    """Layers (K, 3, 4) with NaN and inf, and weights or None."""
    k = draw(st.integers(1, 5))
    layers = draw(nps.arrays(np.float32, (k, *SHAPE), elements=values | st.sampled_from([np.nan, np.inf])))
    weights = draw(st.none() | nps.arrays(np.float32, (k, *SHAPE), elements=st.sampled_from([0.0, 0.5, 1.0, 2.0])))
    return layers, weights


def at_pixel(layers, weights, i, j):
    d = layers[:, i, j].astype(float)
    w = np.ones_like(d) if weights is None else weights[:, i, j].astype(float)
    seen = np.isfinite(d) & (w > 0)
    return d[seen], w[seen]


@given(observations())
def test_median_mean_and_bounds_are_those_of_what_was_observed(given):
    layers, weights = given
    data = Observations.of(layers, weights)
    median, mean = data.median(), data.mean()
    for i, j in np.ndindex(*SHAPE):
        d, w = at_pixel(layers, weights, i, j)
        assert data.count[i, j] == len(d)
        assert data.total[i, j] == w.sum()
        if not len(d):
            assert np.isnan(median[i, j])
            assert np.isnan(mean[i, j])
            continue
        costs = (w * np.abs(d[:, None] - d)).sum(axis=1)
        best = d[costs == costs.min()]  # where the weights tie, every point between two data is a minimiser
        assert median[i, j] == (best.min() + best.max()) / 2
        assert mean[i, j] == pytest.approx(np.average(d, weights=w), abs=1e-6)
    every = [d for i, j in np.ndindex(*SHAPE) for d in at_pixel(layers, weights, i, j)[0]]
    if every:
        assert data.bounds == (min(every), max(every))


@given(observations(), st.integers(0, 4))
def test_the_order_of_the_observations_does_not_matter(given, shift):
    layers, weights = given
    turned = Observations.of(
        np.roll(layers, shift, axis=0), None if weights is None else np.roll(weights, shift, axis=0)
    )
    data, scale, x = Observations.of(layers, weights), np.ones(SHAPE, np.float32), np.zeros(SHAPE, np.float32)
    np.testing.assert_array_equal(turned.stack, data.stack)
    one, other = (AbsoluteDeviations(d, scale).energy(x) for d in (turned, data))
    np.testing.assert_allclose(one, other, rtol=1e-6)


@given(st.integers(1, 4).flatmap(lambda k: nps.arrays(np.float32, (k, *SHAPE), elements=values | st.just(np.nan))))
def test_weight_2_is_the_observation_given_twice_and_weight_0_its_absence(layers):
    scale, x = np.full(SHAPE, 0.5, np.float32), np.linspace(-4, 4, 12, dtype=np.float32).reshape(SHAPE)
    weights = np.ones_like(layers)
    weights[0] = 2
    twice, doubled = Observations.of(np.concatenate([layers, layers[:1]])), Observations.of(layers, weights)
    weights[0] = 0
    without = Observations.of(np.concatenate([layers[1:], np.full_like(layers[:1], np.nan)]))
    absent = Observations.of(layers, weights)
    for one, other in ((twice, doubled), (without, absent)):
        assert_same_term(AbsoluteDeviations(one, scale), AbsoluteDeviations(other, scale), x)
        assert_same_term(AbsoluteDeviations(one, scale, 0.5), AbsoluteDeviations(other, scale, 0.5), x)
        assert_same_term(SquaredDeviations.of(one, scale), SquaredDeviations.of(other, scale), x)
        np.testing.assert_array_equal(one.median(), other.median())


def assert_same_term(one, other, x):
    np.testing.assert_allclose(one.energy(x), other.energy(x), rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(proximal_point(one, x, 0.7), proximal_point(other, x, 0.7), atol=1e-5)
    np.testing.assert_allclose(one.lowest(x, -9.0, 9.0, x), other.lowest(x, -9.0, 9.0, x), rtol=1e-5, atol=1e-4)


def proximal_point(fidelity, y, tau):
    x_bar, zero = np.empty_like(y), np.zeros_like(y)
    fidelity.prox(zero, x_bar, y.copy(), np.float32(tau), np.float32(1))
    return zero


@dataclass
class Term:
    """A data term and, independently, its cost at points z at the pixel (i, j)."""

    fidelity: object
    cost: object


def terms(layers, weights, scale):
    """One of each kind over the same observations."""
    data = Observations.of(layers, weights)
    anchor = np.linspace(3, -3, 12, dtype=np.float32).reshape(SHAPE)

    def summed(rho):
        def cost(z, i, j):
            d, w = at_pixel(layers, weights, i, j)
            return scale[i, j] * (w[:, None] * rho(z - d[:, None])).sum(axis=0)

        return cost

    absolute, squared = summed(np.abs), summed(lambda r: r * r / 2)
    huber = summed(lambda r: np.where(np.abs(r) < 0.5, r * r, np.abs(r) - 0.25))
    return {
        "absolute": Term(AbsoluteDeviations(data, scale), absolute),
        "huber": Term(AbsoluteDeviations(data, scale, 0.5), huber),
        "squared": Term(SquaredDeviations.of(data, scale), squared),
        "anchored": Term(
            Anchored(AbsoluteDeviations(data, scale), anchor, 0.8),
            lambda z, i, j: absolute(z, i, j) + (z - anchor[i, j]) ** 2 / 1.6,
        ),
    }


KINDS = ["absolute", "huber", "squared", "anchored"]
SCALE = np.linspace(0.25, 1.5, 12, dtype=np.float32).reshape(SHAPE)
Y = np.linspace(-5, 6, 12, dtype=np.float32).reshape(SHAPE)[::-1].copy()


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=25)
@given(observations())
def test_energy_and_proximal_map_are_those_of_the_sum_over_the_observations(kind, given):
    term = terms(*given, SCALE)[kind]
    energy, point = np.zeros(SHAPE), proximal_point(term.fidelity, Y, 0.7)
    for i, j in np.ndindex(*SHAPE):
        energy[i, j] = term.cost(Y[i, j : j + 1], i, j)[0]
        best = GRID[np.argmin(term.cost(GRID, i, j) + (GRID - Y[i, j]) ** 2 / 1.4)]
        assert point[i, j] == pytest.approx(best, abs=1.5 / 400)
    np.testing.assert_allclose(term.fidelity.energy(Y), energy.sum(axis=1), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=25)
@given(observations())
def test_lowest_is_the_minimum_and_for_the_anchored_term_a_bound_that_is_tight_at_the_minimiser(kind, given):
    term = terms(*given, SCALE)[kind]
    tilt, low, high = Y / 4, -9.0, 9.0
    costs = np.array([[term.cost(GRID, i, j) + tilt[i, j] * GRID for j in range(4)] for i in range(3)])
    least, at = costs.min(axis=2).sum(axis=1), GRID[costs.argmin(axis=2)].astype(np.float32)
    bound = term.fidelity.lowest(tilt, low, high, at)
    assert (bound <= least + 1e-3).all()
    np.testing.assert_allclose(bound, least, atol=0.08 if kind == "anchored" else 5e-3)
    if kind == "anchored":
        assert (term.fidelity.lowest(tilt, low, high, at + 1) <= least + 1e-3).all()  # a bound from anywhere


@pytest.mark.parametrize("kind", KINDS)
def test_rows_of_a_data_term_are_the_data_term_of_the_rows(kind):
    rng = np.random.default_rng(5)
    layers = rng.normal(size=(3, *SHAPE)).astype(np.float32)
    term = terms(layers, np.abs(layers), SCALE)[kind].fidelity
    part = term.rows(1, 3)
    np.testing.assert_array_equal(part.energy(Y[1:3]), term.energy(Y)[1:3])
    np.testing.assert_array_equal(part.lowest(Y[1:3], -9.0, 9.0, Y[1:3]), term.lowest(Y, -9.0, 9.0, Y)[1:3])
    np.testing.assert_array_equal(proximal_point(part, Y[1:3], 0.7), proximal_point(term, Y, 0.7)[1:3])
