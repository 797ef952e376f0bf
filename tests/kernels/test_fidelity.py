"""Kernels of the data terms against plain NumPy, brute force and SciPy, with ties, weights and missing observations."""

from dataclasses import dataclass

import hypothesis.extra.numpy as nps
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipcli.inverse.regularize import proximal
from ipcli.kernels import fidelity as kernels
from ipcli.kernels import iteration

QUARTERS = st.integers(-40, 40).map(lambda n: n / 4)  # few values, so that observations tie
RHO = np.float32(1.5)


@dataclass
class Case:
    """K observations a pixel as layers (K, h, w), +inf and weight 0 where there is none, and as the kernels
    want them.
    """

    layers: np.ndarray
    weights: np.ndarray
    scale: np.ndarray
    y: np.ndarray
    weighted: bool

    def __post_init__(self):
        order = np.argsort(self.layers, axis=0, kind="stable")
        self.stack, sorted_weights = (
            np.ascontiguousarray(np.take_along_axis(a, order, axis=0).transpose(1, 0, 2))
            for a in (self.layers, self.weights)
        )
        self.kernel_weights = sorted_weights if self.weighted else None
        self.total, self.count = self.weights.sum(axis=0), np.isfinite(self.layers).sum(axis=0).astype(np.float32)

    @property
    def finite(self):
        return np.where(np.isfinite(self.layers), self.layers, 0)


@st.composite
def cases(draw, least=0.0):
    k, h, w = draw(st.integers(1, 6)), draw(st.integers(1, 3)), draw(st.integers(1, 4))

    def planes(shape, elements):
        return draw(nps.arrays(np.float32, shape, elements=elements))

    layers = planes((k, h, w), QUARTERS | st.just(np.inf))
    weighted = draw(st.booleans())
    weights = planes((k, h, w), st.sampled_from([0.25, 0.5, 1.0, 3.0])) if weighted else np.ones((k, h, w), np.float32)
    weights = np.where(np.isfinite(layers), weights, 0).astype(np.float32)
    scale = planes((h, w), st.sampled_from([least, 0.5, 1.0, 2.0]))
    return Case(layers, weights, scale, planes((h, w), QUARTERS), weighted)


def stepped(kernel, case, *middle):
    """The proximal point of a kernel that starts at x = 1, taken back from both of its outputs, which must agree."""
    x, x_bar = np.ones_like(case.y), np.empty_like(case.y)
    kernel(x, x_bar, case.y, *middle, RHO)
    point = (x_bar + 1) / 2
    np.testing.assert_allclose(x, 1 + RHO * (point - 1), atol=3e-5)
    return point


def l1(case, tau):
    return stepped(iteration.prox_l1, case, case.stack, case.kernel_weights, case.total, case.scale, np.float32(tau))


@given(cases(), st.sampled_from([0.125, 0.5, 2.0]))
def test_prox_l1_is_the_median_formula_of_li_and_osher(case, tau):
    twin = proximal.absolute_deviations(case.y, case.finite, case.weights * case.scale, tau)
    np.testing.assert_allclose(l1(case, tau), twin, atol=2e-5)


@given(cases(), st.sampled_from([0.125, 0.5, 2.0]))
def test_prox_l1_is_the_best_of_all_points_a_minimiser_can_be(case, tau):
    """A minimiser is an observation, or where the square balances one of the slopes that subsets of the data
    can give.
    """
    signs = np.sign(np.arange(len(case.layers) + 1)[:, None] - np.arange(len(case.layers)) - 0.5)  # below + ... - above
    slopes = np.einsum(
        "mk,ikj->mij",
        -signs,
        case.weights[
            np.argsort(case.layers, axis=0, kind="stable"),
            np.arange(case.y.shape[0])[:, None],
            np.arange(case.y.shape[1]),
        ].transpose(1, 0, 2),
    )
    candidates = np.concatenate([case.finite, case.y + tau * case.scale * slopes])
    distance = np.abs(candidates[:, None] - case.finite) * case.weights
    costs = case.scale * distance.sum(axis=1) + (candidates - case.y) ** 2 / (2 * tau)
    best = np.take_along_axis(candidates, costs.argmin(axis=0)[None], axis=0)[0]
    np.testing.assert_allclose(l1(case, tau), best, atol=2e-5)


@given(cases(), st.sampled_from([0.125, 2.0]))
def test_prox_l2_is_the_closed_form(case, tau):
    with np.errstate(invalid="ignore"):
        mean = np.nan_to_num((case.finite * case.weights).sum(axis=0) / case.total)
    point = stepped(kernels.prox_l2, case, mean, case.total, case.scale, np.float32(tau))
    twin = proximal.squared_deviations(case.y, case.finite, case.weights * case.scale, tau)
    np.testing.assert_allclose(point, twin, atol=2e-5)


def huber(r, width):
    r = np.abs(r)
    return np.where(r <= width, r * r / (2 * width), r - width / 2)


def prox_huber(case, width, tau):
    data = (case.stack, case.kernel_weights, case.total, case.count, case.scale)
    return stepped(kernels.prox_huber, case, *data, np.float32(width), np.float32(tau))


def test_prox_huber_does_not_go_to_and_fro_between_the_slopes_beside_the_root():
    """Newton's step leads from 0.25 to 2.25 and back; the root 3.125 / 5.5 lies between."""
    layers = np.array([0.5, 0, 0], np.float32).reshape(3, 1, 1)
    case = Case(
        layers, np.ones_like(layers), np.full((1, 1), 0.5, np.float32), np.full((1, 1), 3.25, np.float32), False
    )
    point = prox_huber(case, width=0.1, tau=2)
    assert point.item() == pytest.approx(3.125 / 5.5, abs=1e-6)


@settings(max_examples=30)
@given(cases(least=0.5), st.sampled_from([0.125, 2.0]), st.sampled_from([0.1, 1.0, 30.0]))
def test_prox_huber_is_where_scipy_finds_the_minimum(case, tau, width):
    from scipy.optimize import minimize_scalar

    point = prox_huber(case, width, tau)
    for i, j in np.ndindex(*case.y.shape):
        d, w = case.finite[:, i, j].astype(float), case.weights[:, i, j].astype(float) * case.scale[i, j]
        y, reach = float(case.y[i, j]), tau * w.sum() + 1e-6
        cost = lambda z: (w * huber(z - d, width)).sum() + (z - y) ** 2 / (2 * tau)  # noqa: B023, E731
        best = minimize_scalar(cost, bounds=(y - reach, y + reach), method="bounded", options={"xatol": 1e-9})
        assert point[i, j] == pytest.approx(best.x, abs=3e-5)


@given(cases(), st.sampled_from([0.0, 0.5, 4.0]))
def test_deviation_sums_the_present_observations(case, width):
    r = case.y - case.finite
    each = huber(r, width) if width else np.abs(r)
    got = kernels.deviation(case.y, case.stack, case.kernel_weights, np.float32(width))
    np.testing.assert_allclose(got, (case.weights * each).sum(axis=0), rtol=1e-5, atol=1e-5)


@given(cases())
def test_lowest_l1_rows_is_the_least_value_on_the_data_and_the_ends(case):
    low, high, tilt = -10.5, 11.0, case.y
    candidates = np.concatenate([case.finite, np.full((2, *tilt.shape), [[[low]], [[high]]], np.float32)])
    values = case.scale * (np.abs(candidates[:, None] - case.finite) * case.weights).sum(axis=1) + tilt * candidates
    rows = kernels.lowest_l1_rows(tilt, case.stack, case.kernel_weights, case.total, case.scale, low, high)
    np.testing.assert_allclose(rows, values.min(axis=0).sum(axis=1), rtol=1e-6, atol=1e-4)


@settings(max_examples=50)
@given(cases(), st.sampled_from([0.1, 1.0, 30.0]))
def test_lowest_huber_rows_is_the_least_value_on_a_fine_grid(case, width):
    low, high, tilt = -10.5, 11.0, case.y
    grid = np.linspace(low, high, 4301)[:, None, None]  # a step of 1/200: the data and the kinks lie on it
    values = tilt * grid
    for d, w in zip(case.finite, case.weights, strict=True):
        values = values + case.scale * w * huber(grid - d, width)
    data = (case.stack, case.kernel_weights, case.count, case.scale)
    rows = kernels.lowest_huber_rows(tilt, *data, np.float32(width), low, high)
    least = values.min(axis=0).sum(axis=1)
    np.testing.assert_allclose(rows, least, rtol=1e-5, atol=3e-3)
    assert (rows <= least + 1e-4).all()  # the grid is never below the minimum


@given(cases())
def test_stacks_are_sorted_with_their_weights_and_the_missing_last(case):
    stack, weights = (np.ascontiguousarray(a.transpose(1, 0, 2)) for a in (case.layers, case.weights))
    single = stack.copy()
    single[single == np.inf] = np.nan  # either means that there is none
    kernels.sort_stack(single)
    np.testing.assert_array_equal(single, np.sort(case.layers, axis=0).transpose(1, 0, 2))
    np.testing.assert_array_equal(kernels.count_observations(single), case.count)
    kernels.sort_weighted_stack(stack, weights)
    order = np.argsort(case.layers, axis=0, kind="stable")
    np.testing.assert_array_equal(stack, case.stack)
    np.testing.assert_array_equal(weights, np.take_along_axis(case.weights, order, axis=0).transpose(1, 0, 2))


def test_observations_of_weight_0_are_none():
    stack, weights = np.array([[[1], [-np.inf], [3]]], np.float32), np.array([[[0], [1], [2]]], np.float32)
    kernels.sort_weighted_stack(stack, weights)
    np.testing.assert_array_equal(stack.ravel(), [3, np.inf, np.inf])
    np.testing.assert_array_equal(weights.ravel(), [2, 0, 0])
