"""Gaze corrected by fixation targets: what is known in closed form comes back, outliers do not count."""

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.measurements.recording import FixationTargets, Gaze
from ipcli.models.gaze.gaze_calibration import calibrated

WIDTH = 640.0


def _looked(wrong, count, noise=0.0, seed=0):
    """Gaze of three samples a target, which `wrong` moved away from it, and the targets."""
    rng = np.random.default_rng(seed)
    true = rng.uniform(50, 430, (count, 2))
    times = np.arange(3 * count) * 0.1
    seen = np.repeat(wrong(true) + rng.normal(0, noise, true.shape), 3, axis=0)
    spans = np.stack([times[::3], times[2::3]], axis=1)
    return Gaze(times, seen, np.ones(len(times), bool)), FixationTargets(spans, true), true


def test_an_affine_error_is_undone_exactly():
    turn = np.array([[1.04, -0.03], [0.02, 0.97]])
    gaze, targets, true = _looked(lambda p: p @ turn.T + [12, -7], 8)
    made = calibrated(gaze, targets, WIDTH)
    assert made.kind == "affine"
    np.testing.assert_allclose(made.applied(gaze.pixels[::3]), true, atol=1e-6)
    assert made.error < 1e-6 < made.before


def test_targets_that_were_looked_past_hardly_count():
    gaze, targets, true = _looked(lambda p: p + [12, -7], 12, noise=1.0)
    gaze.pixels[[0, 1, 2, 15, 16, 17]] += 150.0  # the first and the sixth target
    good = np.delete(np.arange(12), [0, 5])
    rest = (calibrated(gaze, targets, WIDTH).applied(gaze.pixels[::3]) - true)[good]
    assert np.abs(rest.mean(axis=0)).max() < 1.5


def test_the_error_at_left_out_targets_is_that_of_the_gaze_and_more_terms_are_no_better():
    kinds, errors = [], []
    for seed in range(20):
        made = calibrated(*_looked(lambda p: p + [20, 5], 40, noise=4.0, seed=seed)[:2], WIDTH)
        kinds.append(made.kind)
        errors.append(made.error)
    assert np.mean(errors) == pytest.approx(4.0, rel=0.12)
    assert kinds.count("shift") >= kinds.count("quadratic")


def test_two_targets_give_a_shift_and_one_gives_nothing():
    gaze, targets, _ = _looked(lambda p: p - 3, 2)
    made = calibrated(gaze, targets, WIDTH)
    assert made.kind == "shift"
    np.testing.assert_allclose(made.weights, [[3, 3]])
    blind = Gaze(gaze.times, gaze.pixels, gaze.times < 0.25)
    with pytest.raises(NoSolution, match="1 of 2 targets have valid gaze"):
        calibrated(blind, targets, WIDTH)
