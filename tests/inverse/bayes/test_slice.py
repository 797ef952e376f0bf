"""A slice sampler leaves a density as it is, whatever its width."""

import math

import numpy as np
import pytest
from scipy import stats

from ipcli.inverse.bayes.slice import draw

THIN = 10


@pytest.mark.parametrize("width", [0.2, 1.0, 30.0])
def test_draws_are_of_the_density(width):
    """Of a skew density on a half line, which is known up to a factor."""
    rng, t, found = np.random.default_rng(0), 1.0, []
    for step in range(20000):
        t = draw(lambda t: 17.0 + (2 * math.log(t) - 3 * t if t > 0 else -math.inf), t, rng, width)
        if step % THIN == 0:
            found.append(t)
    assert stats.kstest(found, stats.gamma(3, scale=1 / 3).cdf).pvalue > 1e-3


def test_both_of_two_modes_are_visited_as_often_as_they_weigh():
    rng, t, found = np.random.default_rng(1), 0.0, []
    for _ in range(20000):
        t = draw(lambda t: float(np.logaddexp(math.log(0.25) - (t + 2) ** 2, math.log(0.75) - (t - 2) ** 2)), t, rng)
        found.append(t > 0)
    assert np.mean(found) == pytest.approx(0.75, abs=0.04)


def test_a_point_mass_is_never_left():
    rng = np.random.default_rng(2)
    assert draw(lambda t: 0.0 if t == 5.0 else -math.inf, 5.0, rng) == pytest.approx(5.0, rel=1e-12)
