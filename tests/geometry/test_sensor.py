from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.geometry.sensor import observe, parse_noise

TRUTH = np.full((300, 400), 3.0)


def seeded() -> np.random.Generator:
    return np.random.default_rng(11)


@pytest.mark.parametrize(("name", "spread"), [("laplace", np.sqrt(2) * 0.05), ("gauss", 0.05)])
def test_noise_has_the_scale_and_the_tails_asked_for(name, spread):
    error = observe(TRUTH, seeded(), (name, 0.05)) - TRUTH
    assert abs(error.mean()) < 5 * spread / np.sqrt(error.size)
    assert error.std() == pytest.approx(spread, rel=0.01)
    kurtosis = np.mean(error**4) / error.std() ** 4
    assert kurtosis == pytest.approx({"laplace": 6.0, "gauss": 3.0}[name], rel=0.06)


def test_outliers_replace_their_share_by_values_in_the_range():
    truth = np.linspace(2.0, 4.0, TRUTH.size).reshape(TRUTH.shape)
    observed = observe(truth, seeded(), ("gauss", 0.0), outliers=0.1)
    wild = observed != truth.astype(np.float32)
    assert wild.mean() == pytest.approx(0.1, abs=0.005)
    assert observed.min() >= 2.0
    assert observed.max() <= 4.0
    assert np.corrcoef(observed[wild], truth[wild])[0, 1] == pytest.approx(0, abs=0.04)


def test_missing_stays_missing_and_does_not_shift_the_draws_of_its_neighbours():
    holed = TRUTH.copy()
    holed[10:20] = np.nan
    whole, observed = (observe(truth, seeded(), ("laplace", 0.1), 0.0) for truth in (TRUTH, holed))
    assert np.isnan(observed[10:20]).all()
    np.testing.assert_array_equal(observed[20:], whole[20:])
    assert np.isnan(observe(np.full((2, 2), np.nan), seeded(), ("gauss", 1.0), 0.5)).all()


def test_depth_is_never_observed_at_or_behind_the_camera():
    observed = observe(np.full((100, 100), 0.1), seeded(), ("gauss", 1.0))
    assert np.isnan(observed).any()
    assert (observed[np.isfinite(observed)] > 0).all()


@pytest.mark.parametrize("text", ["laplace", "laplace:", "laplace:-1", "laplace:nan", "gauss:inf", "uniform:1", ""])
def test_noise_that_cannot_be_read_is_refused(text):
    with pytest.raises(ParameterError, match="expected laplace:SCALE or gauss:SCALE"):
        parse_noise(text)


def test_noise_is_read():
    assert parse_noise("laplace:0.03") == ("laplace", 0.03)
