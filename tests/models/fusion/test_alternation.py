"""Depth and confidence together: each step is the minimum it claims to be, and the merit falls."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from ipcli.inverse.regularize import tgv
from ipcli.inverse.regularize.fidelity import Observations
from ipcli.inverse.regularize.parameters import Solver
from ipcli.models.fusion import alternation
from ipcli.models.fusion.alternation import ALGORITHMS, History, confidence_step, with_given_confidence
from ipcli.models.fusion.fuse import build_problem
from ipcli.models.fusion.parameters import METHODS, Confidence, Fusion

SHAPE = (30, 37)


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Where the algorithms lead, not when they think it is near enough."""
    monkeypatch.setattr(alternation, "SETTLED", 1e-5)


def layers_of(seed, k=4, outliers=0.1, missing=0.15):
    """A roof in units of its noise, with outliers, single gaps and a hole."""
    rng = np.random.default_rng(seed)
    rows, columns = np.indices(SHAPE)
    layers = 20 - np.abs(columns - 18.0) + 0.3 * rows + rng.laplace(size=(k, *SHAPE))
    layers += (rng.random(layers.shape) < outliers) * rng.normal(0, 30, layers.shape)
    layers[rng.random(layers.shape) < missing] = np.nan
    layers[:, 5:11, 8:14] = np.nan
    return layers.astype(np.float32)


def problem_of(seed=0, method="l1-adapt", **settings):
    """Under a weak prior, where the confidence has the most to say."""
    data, prior = Observations.of(layers_of(seed)), Confidence(**{"shape": 1.5, "rate": 0.1} | settings)
    return build_problem(data, 0.3, METHODS[method], Fusion(confidence=prior)), data


def iterate_of(problem, data, solver=Solver()):
    iterate = tgv.Iterate.at(np.where(data.count > 0, data.median(), 20))
    history = History()
    with_given_confidence(problem, np.ones(SHAPE, np.float32), iterate, solver, history)
    return iterate, history


def merits(history):
    column = np.array(history.rows)[:, 4]
    return column[np.isfinite(column)]


def energy_in_l(problem, x, *at):
    """The part of (4.3) that holds the confidence of one pixel, or of one observation."""
    deviation = float(problem.deviations(x)[at])
    b, rate = float(problem.b[at]), float(problem.rate[at])
    return lambda log_l: np.exp(log_l) * (deviation + rate) - b * log_l


@pytest.mark.parametrize("method", ["l1-adapt", "rof-adapt"])
@pytest.mark.parametrize("settings", [{}, {"b": 0.6, "rate": 2.0}, {"shape": 21.0, "rate": 20.0}], ids=str)
def test_the_best_confidence_is_the_minimum_in_l_and_0_without_observations(method, settings):
    problem, data = problem_of(method=method, **settings)
    x = np.full(SHAPE, 18, np.float32)
    confidence = problem.best_confidence(x)
    for i, j in [(0, 0), (3, 30), (20, 11), (29, 36)]:
        best = minimize_scalar(
            energy_in_l(problem, x, i, j), bounds=(-20, 20), method="bounded", options={"xatol": 1e-9}
        )
        assert confidence[i, j] == pytest.approx(np.exp(best.x), rel=1e-4)
    np.testing.assert_array_equal(confidence == 0, data.count == 0)


def test_the_best_confidence_of_an_observation_is_the_minimum_in_it():
    problem, data = problem_of(method="l1-adapt-views")
    x = np.full(SHAPE, 18, np.float32)
    confidence = problem.best_confidence(x)
    for i, k, j in [(0, 0, 0), (3, 1, 30), (20, 0, 11), (29, 2, 36)]:
        deviation = abs(18 - float(data.stack[i, k, j]))
        b, rate = 1 + 0.5 / data.count[i, j], 0.1 / data.count[i, j]

        def merit(log_l, deviation=deviation, rate=rate, b=b):
            return np.exp(log_l) * (deviation + rate) - b * log_l

        best = minimize_scalar(merit, bounds=(-20, 20), method="bounded")
        assert confidence[i, k, j] == pytest.approx(np.exp(best.x), rel=1e-3)
    np.testing.assert_array_equal(confidence == 0, np.isinf(data.stack))


def test_observations_that_deviate_alike_are_as_confident_as_their_pixel():
    """And their data terms are then the same, weighed by what was given with the views or not."""
    layers = np.stack([np.full(SHAPE, value, np.float32) for value in (2, 4, 2, 4)])
    layers[3, :8] = np.nan
    weights = np.random.default_rng(0).uniform(0.5, 2, layers.shape[1:]).astype(np.float32)
    for given in (None, np.broadcast_to(weights, layers.shape)):
        data, x = Observations.of(layers, given), np.full(SHAPE, 3, np.float32)
        both = [build_problem(data, 0.3, METHODS[name], Fusion()) for name in ("l1-adapt", "l1-adapt-views")]
        of_pixels, of_each = (problem.best_confidence(x) for problem in both)
        np.testing.assert_allclose(of_each, np.where(np.isfinite(data.stack), of_pixels[:, None], 0), rtol=1e-5)
        np.testing.assert_allclose(both[1].of_pixels(of_each), of_pixels, rtol=1e-5)
        energies = [
            problem.at(confidence).energy(x + 1) for problem, confidence in zip(both, (of_pixels, of_each), strict=True)
        ]
        np.testing.assert_allclose(*energies, rtol=1e-5)


def test_a_view_that_is_off_loses_its_say_where_its_pixel_keeps_it():
    """Two views agree with the image and one does not: its confidence falls, not that of the others."""
    layers = np.stack([np.full(SHAPE, value, np.float32) for value in (0.0, 0.5, 30.0)])
    problem = build_problem(Observations.of(layers), 0.3, METHODS["l1-adapt-views"], Fusion())
    confidence = problem.best_confidence(np.zeros(SHAPE, np.float32))
    assert (confidence[:, 2] < 0.3 * confidence[:, 1]).all()
    assert (confidence[:, 0] > confidence[:, 1]).all()


@pytest.mark.parametrize("step", [0.01, 0.25, 10.0])
def test_the_proximal_step_of_the_confidence_is_the_minimum_it_stands_for(step):
    problem, data = problem_of()
    rng = np.random.default_rng(1)
    x, confidence = np.full(SHAPE, 18, np.float32), rng.uniform(0.1, 4, SHAPE).astype(np.float32)
    stepped = confidence_step(confidence, problem, x, step)
    for i, j in [(0, 0), (3, 30), (20, 11), (29, 36)]:
        plain, before = energy_in_l(problem, x, i, j), float(confidence[i, j])
        whole = lambda log_l: plain(log_l) + (np.exp(log_l) - before) ** 2 / (2 * step)  # noqa: B023, E731
        best = minimize_scalar(whole, bounds=(-20, 20), method="bounded", options={"xatol": 1e-9})
        assert stepped[i, j] == pytest.approx(np.exp(best.x), rel=1e-3)
    assert not stepped[data.count == 0].any()


def test_an_endless_proximal_step_is_the_best_confidence():
    """In float32 the root of (4.17) as printed cancels to multiples of 1/16, or to 0."""
    problem, _ = problem_of()
    x = np.full(SHAPE, 18, np.float32)
    best = problem.best_confidence(x)
    np.testing.assert_allclose(confidence_step(np.ones_like(x), problem, x, 1e6), best, rtol=1e-4)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("method", ["l1-adapt", "l1-adapt-views", "rof-adapt"])
@pytest.mark.parametrize("settings", [{}, {"b": 6.0, "rate": 1.0}], ids=str)
def test_alternate_convex_search_never_raises_the_merit(seed, method, settings):
    problem, data = problem_of(seed, method, **settings)
    iterate, history = iterate_of(problem, data)
    ALGORITHMS["acs"](problem, iterate, Solver(), 8, history)
    falls = -np.diff(merits(history))
    assert len(falls) >= 2
    assert (falls >= -1e-7 * np.abs(merits(history)[1:])).all()
    assert falls[0] > 0


def test_a_round_that_runs_out_of_iterations_does_not_raise_the_merit_either():
    """One iteration a round from a good start: the energy is above the one at the start."""
    problem, data = problem_of(3)
    iterate, history = iterate_of(problem, data, Solver(tolerance=1e-5, iterations=4000))
    iterate.p[:], iterate.q[:] = 0, 0
    ALGORITHMS["acs"](problem, iterate, Solver(iterations=1, check=1), 5, history)
    assert (np.diff(merits(history)) <= 1e-7 * merits(history)[0]).all()


def test_the_merit_is_the_energy_with_the_best_confidence_put_in():
    """F = E(x, L(x)) - lambda sum b (1 - log b) over the observed pixels."""
    problem, data = problem_of()
    iterate, _ = iterate_of(problem, data)
    best, seen = problem.best_confidence(iterate.x).astype(float), data.count > 0
    entropy = (problem.rate * best - problem.b * np.log(np.where(seen, best, 1))).sum(where=seen)
    energy = iterate.energy(problem.at(best), problem.regulariser) + problem.lam * entropy
    constant = problem.lam * (problem.b * (1 - np.log(problem.b))).sum(where=seen)
    assert problem.merit(iterate) == pytest.approx(energy - constant, rel=1e-5)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("method", "prior"), [("l1-adapt", {}), ("l1-adapt-views", {"shape": 21.0, "rate": 20.0})])
def test_the_three_algorithms_end_at_nearly_the_same_merit_and_depth(seed, method, prior):
    """The biconvex method moves the confidence in each iteration and circles around its end, at some thousandth of the
    merit.

    The confidences of single observations under a weak prior have many minima, and each algorithm finds its own.
    """
    solver, merit, depth = Solver(tolerance=1e-4, iterations=2000), {}, {}
    for name, rounds in {"acs": 12, "ama": 12, "biconvex": 40}.items():
        problem, data = problem_of(seed, method, **prior)
        iterate, history = iterate_of(problem, data, solver)
        ALGORITHMS[name](problem, iterate, solver, rounds, history)
        merit[name], depth[name] = merits(history)[-1], iterate.x
    gain = merits(history)[0] - merit["acs"]
    assert gain > 0
    assert abs(merit["ama"] - merit["acs"]) < 0.05 * gain
    assert merit["biconvex"] == pytest.approx(merit["acs"], rel=5e-3)
    for name, median in {"ama": 0.01, "biconvex": 0.05}.items():  # in units of the noise
        apart = np.abs(depth[name] - depth["acs"])
        assert np.median(apart) < median
        assert np.quantile(apart, 0.99) < 10 * median


def test_alternating_minimisation_gets_as_far_in_the_default_rounds_as_alternate_convex_search():
    """Its first rounds are held back and gain little; it must not take this for the end."""
    gains = {}
    for name in ("acs", "ama"):
        problem, data = problem_of()
        iterate, history = iterate_of(problem, data)
        ALGORITHMS[name](problem, iterate, Solver(), Fusion.rounds, history)
        gains[name] = merits(history)[0] - merits(history)[-1]
    assert gains["ama"] > 0.9 * gains["acs"] > 0


def test_the_history_counts_rounds_and_iterations_on_and_marks_each_round_s_end():
    problem, data = problem_of()
    solver = replace(Solver(), iterations=150, tolerance=0.0)
    iterate, history = iterate_of(problem, data, solver)
    ALGORITHMS["acs"](problem, iterate, solver, 2, history)
    rows = np.array(history.rows)
    np.testing.assert_array_equal(rows[:9, 0], np.repeat([0, 1, 2], 3))
    np.testing.assert_array_equal(np.diff(rows[:9, 1]), 50)
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(rows[:9, 4])), [2, 5, 8])


def test_a_confident_pixel_is_one_whose_observations_agree_with_the_depth():
    problem, _ = problem_of()
    x = np.full(SHAPE, 18, np.float32)
    deviation, confidence = problem.fidelity.deviation(x), problem.best_confidence(x)
    for count in np.unique(problem.b)[1:]:
        here = (problem.b == count) & (confidence > 0)
        order = np.argsort(deviation[here])
        assert (np.diff(confidence[here][order]) <= 0).all()
