"""Properties of SE(3), Sim(3) and the affine group (thesis 2.4): group laws, Jacobians against differences, means."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from ipcli.geometry import lie


def vectors(size, most):
    return st.lists(st.floats(-most, most), min_size=size, max_size=size).map(np.array)


twists = vectors(6, 1.7)


def algebra(twist):
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[:3, 3] = lie.hat(twist[:3]), twist[3:6]
    return matrix


@given(twists)
def test_se3_exp_is_the_matrix_exponential(twist):
    assert np.allclose(lie.se3_exp(twist), expm(algebra(twist)), atol=1e-12)


@given(twists)
def test_se3_log_undoes_exp(twist):
    assert np.allclose(lie.se3_log(lie.se3_exp(twist)), twist, atol=1e-7)


@given(twists)
def test_se3_inverse_is_the_exponential_of_the_negative_twist(twist):
    assert np.allclose(lie.se3_inverse(lie.se3_exp(twist)), lie.se3_exp(-twist), atol=1e-12)


@given(twists, twists)
def test_the_adjoint_carries_a_twist_through_a_motion(a, b):
    motion = lie.se3_exp(a)
    left = motion @ lie.se3_exp(b) @ lie.se3_inverse(motion)
    assert np.allclose(left, expm(algebra(lie.se3_adjoint(motion) @ b)), atol=1e-9)


@given(twists, twists)
def test_adjoints_multiply_like_motions(a, b):
    first, second = lie.se3_exp(a), lie.se3_exp(b)
    assert np.allclose(lie.se3_adjoint(first @ second), lie.se3_adjoint(first) @ lie.se3_adjoint(second), atol=1e-9)


@given(vectors(3, 1.7))
def test_the_left_jacobian_is_the_derivative_of_the_exponential(omega):
    h = 1e-6
    for axis in range(3):
        step = np.eye(3)[axis] * h
        plus, minus = lie.exp(omega + step), lie.exp(omega - step)
        slope = lie.log(plus @ minus.T) / (2 * h)
        assert np.allclose(lie.left_jacobian(omega)[:, axis], slope, atol=1e-6)


@given(vectors(3, 1.7))
def test_the_inverse_of_the_left_jacobian(omega):
    assert np.allclose(lie.left_jacobian(omega) @ lie.left_jacobian_inverse(omega), np.eye(3), atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, 9.9e-3, 1.01e-2, 0.1])
def test_small_angles_lose_no_digits(angle):
    omega = angle * np.array([0.6, -0.0, 0.8])
    series = sum(np.linalg.matrix_power(lie.hat(omega), k) / float(np.prod(range(1, k + 2))) for k in range(8))
    assert np.allclose(lie.left_jacobian(omega), series, atol=1e-13)


@given(vectors(3, 5.0), vectors(3, 5.0))
def test_hat_is_the_cross_product_and_vee_its_inverse(a, b):
    assert np.allclose(lie.hat(a) @ b, np.cross(a, b), atol=1e-9)
    assert (lie.vee(lie.hat(a)) == a).all()


@given(twists, twists)
def test_interpolation_begins_and_ends_where_it_should(a, b):
    first, second = lie.se3_exp(0.5 * a), lie.se3_exp(0.5 * b)
    ends = lie.se3_interpolate(first[None], second[None], np.array([0.0, 1.0]))
    assert np.allclose(ends[0], first, atol=1e-9)
    assert np.allclose(ends[1], second, atol=1e-7)


@given(vectors(7, 1.2))
def test_sim3_exp_is_the_matrix_exponential_and_log_undoes_it(twist):
    matrix = algebra(twist)
    matrix[:3, :3] += twist[6] * np.eye(3)
    assert np.allclose(lie.sim3_exp(twist), expm(matrix), atol=1e-10)
    assert np.allclose(lie.sim3_log(lie.sim3_exp(twist)), twist, atol=1e-7)


@given(vectors(12, 0.4))
@settings(max_examples=40)
def test_affine_log_undoes_exp(values):
    matrix = np.vstack([values.reshape(3, 4), np.zeros(4)])
    assert np.allclose(lie.affine_log(lie.affine_exp(matrix)), matrix, atol=1e-8)


def test_an_affine_map_that_mirrors_has_no_real_logarithm():
    assert np.isnan(lie.affine_log(np.diag([-1.0, 1.0, 1.0, 1.0]))).all()


@given(st.integers(0, 10_000))
@settings(max_examples=30)
def test_the_karcher_mean_moves_with_the_motions_on_both_sides(seed):
    rng = np.random.default_rng(seed)
    motions = lie.se3_exp(rng.normal(0, 0.3, (6, 6)))
    left, right = lie.se3_exp(rng.normal(0, 1, 6)), lie.se3_exp(rng.normal(0, 1, 6))
    mean = lie.se3_karcher_mean(motions)
    assert np.abs(lie.se3_log(lie.se3_inverse(mean) @ motions).sum(axis=0)).max() < 1e-9
    assert np.allclose(lie.se3_karcher_mean(left @ motions @ right), left @ mean @ right, atol=1e-8)
