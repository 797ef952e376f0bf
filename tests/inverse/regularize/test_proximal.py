"""Every proximal map against Moreau's identity, with its conjugate's map written down by itself."""

import hypothesis.extra.numpy as nps
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.inverse.regularize.proximal import (
    absolute_deviations,
    moreau_residual,
    project_balls,
    shrink_balls,
    squared_deviations,
)

STEPS = (0.1, 1.0, 7.0)
numbers = st.floats(-20, 20)
points = nps.arrays(np.float64, 6, elements=numbers)
data = nps.arrays(np.float64, (3, 6), elements=numbers)
each_step = pytest.mark.parametrize("t", STEPS)


@each_step
@pytest.mark.parametrize("multiplicity", [(1, 1), (1, 1, 2)])
@given(st.data(), st.floats(0.1, 9))
def test_shrinking_and_projecting_are_conjugate(t, multiplicity, data, radius):
    """prox of t radius |.| and of the conjugate, the indicator of the ball; the mixed entry counts twice in both."""
    y = data.draw(nps.arrays(np.float64, (len(multiplicity), 5), elements=numbers))

    def shrink(point, step):
        return shrink_balls(point, step * radius, multiplicity)

    def project(point, step):
        return project_balls(point, radius, multiplicity)

    assert moreau_residual(shrink, project, y, t) < 1e-12


@given(nps.arrays(np.float64, (3, 5), elements=numbers), st.floats(0.1, 9))
def test_projection_ends_in_the_ball_and_keeps_what_is_inside(q, radius):
    projected = project_balls(q, radius, (1, 1, 2))
    size = lambda q: np.sqrt(q[0] ** 2 + q[1] ** 2 + 2 * q[2] ** 2)  # noqa: E731
    assert (size(projected) <= radius * (1 + 1e-12)).all()
    np.testing.assert_array_equal(projected[:, size(q) <= radius], q[:, size(q) <= radius])


@each_step
@given(points, data)
def test_squared_deviations_are_conjugate_to_their_closed_form(t, y, data):
    weights = np.array([[0.5], [1.0], [2.0]]) * np.ones_like(data)
    total, pull = weights.sum(axis=0), (weights * data).sum(axis=0)

    def conjugate(point, s):  # the conjugate is (u + pull)^2 / (2 total), up to a constant
        return (total * point - s * pull) / (total + s)

    assert moreau_residual(lambda y, t: squared_deviations(y, data, weights, t), conjugate, y, t) < 1e-10


@each_step
@given(points, nps.arrays(np.float64, 6, elements=numbers))
def test_one_absolute_deviation_is_conjugate_to_a_shifted_clip(t, y, d):
    weights = np.full((1, 6), 0.7)

    def conjugate(point, s):  # the conjugate of 0.7 |x - d| is d u on [-0.7, 0.7]
        return np.clip(point - s * d, -0.7, 0.7)

    assert moreau_residual(lambda y, t: absolute_deviations(y, d[None], weights, t), conjugate, y, t) < 1e-12


@each_step
@given(points, data, nps.arrays(np.float64, (3, 6), elements=st.sampled_from([0.0, 0.5, 1.0, 2.0])))
def test_several_absolute_deviations_meet_their_optimality_condition(t, y, data, weights):
    """(y - x) / t is a subgradient of the convex sum of w |x - d| at x."""
    x = absolute_deviations(y, data, weights, t)
    side = np.where(np.abs(x - data) < 1e-9, 0, np.sign(x - data))
    slope, kink = (weights * side).sum(axis=0), (weights * (side == 0)).sum(axis=0)
    assert (np.abs((y - x) / t - slope) <= kink + 1e-8 / t).all()
