"""SO(3) and SE(3) against series, closed forms, other libraries' means, and the invariances that define them."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from ipcli.geometry import lie

seeds = st.integers(0, 2**32 - 1)


def rng_of(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def rotations(rng: np.random.Generator, *shape: int, spread: float | None = None) -> np.ndarray:
    """Uniform ones, or ones within `spread` radians of a uniform one for each leading index."""
    if spread is None:
        return Rotation.random(int(np.prod(shape)), rng=rng).as_matrix().reshape(*shape, 3, 3)
    vectors = rng.normal(size=(*shape, 3))
    vectors *= spread * rng.random((*shape, 1)) / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return rotations(rng, *shape[:-1], 1) @ lie.exp(vectors)


@given(seeds)
def test_exp_is_the_matrix_exponential_and_log_its_inverse(seed):
    rng = rng_of(seed)
    vector = rng.normal(size=3)
    vector *= rng.choice([1e-9, 1e-4, 1.0, 3.1, np.pi - 1e-7]) / np.linalg.norm(vector)
    x, y, z = vector
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    np.testing.assert_allclose(lie.exp(vector), scipy.linalg.expm(skew), atol=1e-13)
    np.testing.assert_allclose(lie.log(lie.exp(vector)), vector, atol=1e-8 if abs(vector).max() > 3 else 1e-13)


def test_half_a_turn_and_the_identity_have_logarithms():
    np.testing.assert_allclose(
        lie.log(np.stack([np.eye(3), np.diag([-1.0, 1, -1])])), [[0, 0, 0], [0, np.pi, 0]], atol=1e-15
    )


def test_unknown_rotations_give_unknown_logarithms_and_leave_the_others_alone():
    many = rotations(rng_of(0), 3, 2)
    many[1, 0, 2, 2] = np.nan
    logs = lie.log(many)
    assert np.isnan(logs[1, 0]).all()
    np.testing.assert_array_equal(logs[0], lie.log(many[0]))
    np.testing.assert_allclose(lie.exp(logs)[2], many[2], atol=1e-14)
    assert np.isnan(lie.exp(logs)[1, 0]).all()
    assert lie.log(np.empty((0, 3, 3))).shape == (0, 3)


@given(seeds)
def test_means_of_two_are_the_middle_of_the_geodesic(seed):
    rng = rng_of(seed)
    first, turn = rotations(rng, 4), rng.normal(size=(4, 3))
    turn *= (3.0 * rng.random((4, 1))) / np.linalg.norm(turn, axis=-1, keepdims=True)
    pair = np.stack([first, first @ lie.exp(turn)], axis=1)
    middle = first @ lie.exp(turn / 2)
    np.testing.assert_allclose(lie.karcher_mean(pair), middle, atol=1e-11)
    np.testing.assert_allclose(lie.chordal_mean(pair), middle, atol=1e-11)


def test_mean_of_turns_about_one_axis_is_the_mean_of_their_angles():
    angles = np.array([0.1, 0.9, -0.4, 1.2])
    about_z = lie.exp(np.stack([0 * angles, 0 * angles, angles], axis=-1))
    np.testing.assert_allclose(lie.log(lie.karcher_mean(about_z)), [0, 0, angles.mean()], atol=1e-12)
    chordal = np.arctan2(np.sin(angles).sum(), np.cos(angles).sum())
    np.testing.assert_allclose(lie.log(lie.chordal_mean(about_z)), [0, 0, chordal], atol=1e-12)
    assert abs(chordal - angles.mean()) > 0.005  # the two means are not the same thing


@given(seeds)
def test_chordal_mean_is_that_of_scipy(seed):
    many = rotations(rng_of(seed), 3, 5, spread=2.0)
    expected = [Rotation.from_matrix(one).mean().as_matrix() for one in many]
    np.testing.assert_allclose(lie.chordal_mean(many), expected, atol=1e-9)


@given(seeds)
def test_karcher_mean_minimises_the_squared_distances(seed):
    many = rotations(rng_of(seed), 4, spread=1.2)
    mean = lie.karcher_mean(many)
    found = minimize(lambda v: (lie.angle(mean @ lie.exp(v), many) ** 2).sum(), np.full(3, 0.05), tol=1e-12)
    np.testing.assert_allclose(found.x, 0, atol=1e-5)


@given(seeds)
def test_karcher_mean_turns_with_its_data_on_both_sides_and_inverts_with_it(seed):
    rng = rng_of(seed)
    many, left, right = rotations(rng, 2, 5, spread=1.0), rotations(rng, 1)[0], rotations(rng, 1)[0]
    mean = lie.karcher_mean(many)
    np.testing.assert_allclose(lie.karcher_mean(left @ many @ right), left @ mean @ right, atol=1e-10)
    np.testing.assert_allclose(lie.karcher_mean(np.swapaxes(many, -1, -2)), np.swapaxes(mean, -1, -2), atol=1e-10)
    np.testing.assert_allclose(lie.karcher_mean(many[:, ::-1]), mean, atol=1e-10)


def test_logarithms_at_the_karcher_mean_sum_to_zero_for_a_large_batch():
    many = rotations(rng_of(5), 2000, 4, spread=1.4)
    mean = lie.karcher_mean(many)
    sums = lie.log(np.swapaxes(mean, -1, -2)[:, None] @ many).sum(axis=1)
    assert np.abs(sums).max() < 1e-11


def test_means_leave_out_what_is_unknown():
    many = rotations(rng_of(7), 3, 5, spread=1.0)
    gaps = many.copy()
    gaps[0, 2] = np.nan
    gaps[1] = np.nan
    for mean in (lie.karcher_mean, lie.chordal_mean):
        np.testing.assert_allclose(mean(gaps)[0], mean(np.delete(many[0], 2, axis=0)), atol=1e-12)
        np.testing.assert_allclose(mean(gaps)[2], mean(many[2]), atol=1e-12)
        assert np.isnan(mean(gaps)[1]).all()


@given(seeds)
def test_product_log_and_exp_are_inverse_and_follow_the_geodesic_of_5_5(seed):
    rng = rng_of(seed)
    rotation, d = rotations(rng, 2, 1), rng.normal(size=(2, 1, 3))
    others, ds = rotation @ lie.exp(rng.uniform(-1, 1, (2, 6, 3))), rng.normal(size=(2, 6, 3))
    twists = lie.product_log(rotation, d, others, ds)
    for got, expected in zip(lie.product_exp(rotation, d, twists), (others, ds), strict=True):
        np.testing.assert_allclose(got, expected, atol=1e-12)
    h = 1e-6  # Gamma^-1 Gamma' at t = 0, by differences of (5.5)

    def at(t):
        return rotation @ lie.exp(t * lie.log(np.swapaxes(rotation, -1, -2) @ others)), d + t * (ds - d)

    turn, move = (after - before for after, before in zip(at(h), at(-h), strict=True))
    omega = np.swapaxes(rotation, -1, -2) @ turn / (2 * h)
    np.testing.assert_allclose(
        twists[..., :3], np.stack([omega[..., 2, 1], omega[..., 0, 2], omega[..., 1, 0]], -1), atol=1e-8
    )
    np.testing.assert_allclose(twists[..., 3:], np.einsum("...ji,...j->...i", rotation, move / (2 * h)), atol=1e-8)


def test_twists_at_the_product_mean_sum_to_zero_and_do_not_feel_the_world_frame():
    rng = rng_of(3)
    many, ds = rotations(rng, 30, 4, spread=1.0), rng.normal(size=(30, 4, 3))
    world, shift = rotations(rng, 1)[0], rng.normal(size=3)

    def twists(many, ds):
        mean, d = lie.product_mean(many, ds)
        return lie.product_log(mean[:, None], d[:, None], many, ds)

    own = twists(many, ds)
    assert np.abs(own.sum(axis=1)).max() < 1e-10
    np.testing.assert_allclose(twists(world @ many, ds @ world.T + shift), own, atol=1e-10)


def test_product_mean_counts_a_motion_only_when_both_parts_are_known():
    rng = rng_of(4)
    many, ds = rotations(rng, 4, spread=1.0), rng.normal(size=(4, 3))
    gap = ds.copy()
    gap[1, 0] = np.nan
    mean, d = lie.product_mean(many, gap)
    np.testing.assert_allclose(d, ds[[0, 2, 3]].mean(axis=0), atol=1e-14)
    np.testing.assert_allclose(mean, lie.karcher_mean(many[[0, 2, 3]]), atol=1e-12)
    assert all(np.isnan(part).all() for part in lie.product_mean(many, np.full((4, 3), np.nan)))


@given(seeds)
def test_screw_exp_is_the_matrix_exponential_of_the_twist(seed):
    twists = rng_of(seed).normal(size=(2, 3, 6)) * 1.5
    rotation, move = lie.screw_exp(twists)
    for index in np.ndindex(2, 3):
        (x, y, z), v = twists[index][:3], twists[index][3:]
        matrix = np.zeros((4, 4))
        matrix[:3, :3], matrix[:3, 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]], v
        expected = scipy.linalg.expm(matrix)
        np.testing.assert_allclose(rotation[index], expected[:3, :3], atol=1e-12)
        np.testing.assert_allclose(move[index], expected[:3, 3], atol=1e-12)
    assert np.isnan(lie.screw_exp(np.full((1, 6), np.nan))[1]).all()


@pytest.mark.parametrize("near", [1.0, 1e-3, 1e-7, 1e-12, 0.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_minimal_rotation_carries_x_there_by_the_smallest_angle(near, side):
    rng = rng_of(1)
    directions = side * lie.X_AXIS + near * np.concatenate([np.zeros((50, 1)), rng.normal(size=(50, 2))], axis=-1)
    found = lie.minimal_rotation(3.0 * directions)
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    np.testing.assert_allclose(found[..., 0], unit, atol=1e-15)
    np.testing.assert_allclose(np.swapaxes(found, -1, -2) @ found, np.broadcast_to(np.eye(3), found.shape), atol=4e-15)
    np.testing.assert_allclose(np.linalg.det(found), 1, atol=4e-15)
    smallest = np.arctan2(np.linalg.norm(unit[:, 1:], axis=-1), unit[:, 0])
    np.testing.assert_allclose(np.linalg.norm(lie.log(found), axis=-1), smallest, atol=1e-7)


def test_minimal_rotation_turns_about_an_axis_across_both_directions():
    directions = rng_of(2).normal(size=(100, 3))
    np.testing.assert_allclose(lie.log(lie.minimal_rotation(directions))[:, 0], 0, atol=1e-13)


def test_minimal_rotation_of_no_direction_is_unknown():
    assert np.isnan(lie.minimal_rotation(np.array([[0.0, 0, 0], [np.nan, 1, 0]]))).all()
