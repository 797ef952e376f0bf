"""What chapter 5 prints and the code does otherwise: each check fails for the printed form (docs/errata.md)."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import wishart

from ipcli.geometry import lie
from ipcli.inverse.bayes.normal_wishart import NormalWishart
from ipcli.models.mocap import features, recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.parameters import Decision, Features
from tests.fixtures.mocap_bodies import GROUPS, poses

TWIST = np.array([0.4, -0.9, 0.7, 0.5, 0.8, -0.3])


def length(path):
    """Of a path of rigid motions (R (n, 3, 3), d (n, 3)) in the product metric."""
    turned = lie.angle(path[0][:-1], path[0][1:])
    return np.hypot(turned, np.linalg.norm(np.diff(path[1], axis=0), axis=1)).sum()


def test_a_screw_is_no_geodesic_of_the_metric_that_the_mean_is_of():
    """(5.5) against line 2 of Algorithm 5.2: another path between the same ends is shorter than the screw."""
    steps = np.linspace(0, 1, 400)[:, None]
    screw = lie.screw_exp(steps * TWIST)
    ends = lie.product_log(np.eye(3), np.zeros(3), screw[0][-1], screw[1][-1])
    geodesic = lie.product_exp(np.eye(3), np.zeros(3), steps * ends)
    np.testing.assert_allclose(geodesic[1][-1], screw[1][-1], atol=1e-12)
    assert length(geodesic) < 0.99 * length(screw)
    assert np.abs(lie.product_exp(np.eye(3), np.zeros(3), TWIST)[1] - screw[1][-1]).max() > 0.1


def test_the_twist_of_a_geodesic_depends_on_where_along_it_one_looks():
    """Line 3 of Algorithm 5.1 leaves t open, but the directions at t = 1 are others than at t = 0."""
    rng = np.random.default_rng(0)
    rotations, places = lie.exp(0.8 * rng.standard_normal((4, 3))), rng.standard_normal((4, 3))
    mean = lie.product_mean(rotations, places)
    start = lie.product_log(*mean, rotations, places)
    turned = np.einsum("nji,nj->ni", lie.exp(start[:, :3]), start[:, 3:])  # exp(-Omega t) v at t = 1
    end = np.concatenate([start[:, :3], turned], axis=1)
    first = [features.principal_directions(twists)[1][0] for twists in (start, end)]
    assert abs(first[0] @ first[1]) < 0.99


def test_the_eigenvector_with_its_sign_turned_is_as_good_and_gives_other_features():
    twists = np.random.default_rng(1).standard_normal((3, 6))
    scatter, first = twists.T @ twists / 3, features.principal_directions(twists)[1][0]
    for direction in (first, -first):
        np.testing.assert_allclose(scatter @ direction, (first @ scatter @ first) * direction, atol=1e-12)
    one, other = lie.screw_exp(first), lie.screw_exp(-first)
    assert np.linalg.norm(lie.log(one[0]) - lie.log(other[0])) > 0.1


def test_the_seventh_printed_feature_follows_from_the_first_three():
    """e has unit length, so that the norm of its linear part is sqrt(1 - |omega|^2): seven numbers, five degrees of
    freedom.
    """
    moved = poses(20, 0)
    lengths = features.reference_lengths([moved], GROUPS)
    for part in features.of_motion(moved, GROUPS, lengths, Features(kind="thesis")).values():
        np.testing.assert_allclose(part[:, 6] ** 2 + (part[:, :3] ** 2).sum(axis=1), 1, atol=1e-9)


def test_the_precision_of_a_cluster_has_the_mean_that_w_is_named_for():
    """(5.9): with scale (beta W)^-1 the mean precision is W^-1; with the printed beta W^-1 it is beta^2 times
    as much.
    """
    w, beta = np.array([[2.0, 0.5], [0.5, 1.0]]), 6.0
    root = NormalWishart(
        *(np.repeat(a, 20000, axis=0) for a in (np.zeros((1, 2)), [1.0], [beta], beta * w[None]))
    ).sample(np.random.default_rng(2))[1]
    mean = (root @ root.swapaxes(1, 2)).mean(axis=0)
    np.testing.assert_allclose(mean, np.linalg.inv(w), rtol=0.05)
    np.testing.assert_allclose(wishart(beta, beta * np.linalg.inv(w)).mean(), beta**2 * np.linalg.inv(w))


@given(st.lists(st.floats(-40, 40), min_size=3, max_size=3), st.sampled_from(["product", "mean", "preferences"]))
def test_the_unit_of_a_group_makes_no_difference(shifts, rule):
    """W'F: another unit multiplies all densities of a group by one number. Of normalised posteriors it falls out."""
    density = 3 * np.random.default_rng(3).standard_normal((50, 4, 3))
    model = Model(tuple("abcd"), tuple("xyz"), (), (), np.random.default_rng(4).uniform(0.5, 5, (4, 3)))
    one, other = (recognition.frame_posteriors(model, d, Decision(rule=rule)) for d in (density, density + shifts))
    np.testing.assert_allclose(one, other, atol=1e-9)


def test_of_bare_densities_the_sharpest_group_decides_alone():
    """Two groups say the first action, the third one, measured in a smaller unit, the second; all mixed by equal
    preferences.
    """
    posterior = np.log([[[0.9, 0.9, 0.4], [0.1, 0.1, 0.6]]])
    bare = logsumexp(posterior + [0.0, 0.0, 20.0], axis=2)
    model = Model(tuple("ab"), tuple("xyz"), (), (), np.ones((2, 3)))
    assert bare.argmax(axis=1) == [1]
    assert recognition.frame_posteriors(model, posterior + [0.0, 0.0, 20.0], Decision(rule="preferences")).argmax(
        axis=1
    ) == [0]


def test_single_frames_and_whole_clips_are_two_figures():
    """Table 5.1 sets frames of one method beside sequences of the other: of frames six in ten are right here, of clips
    all.
    """
    rng, truth, clip = np.random.default_rng(5), np.repeat(np.arange(5), 60), np.repeat(np.arange(5), 60)
    posterior = rng.dirichlet(np.ones(5), 300) + np.eye(5)[truth] * 0.3
    log_posterior = np.log(posterior / posterior.sum(axis=1, keepdims=True))
    frames = (log_posterior.argmax(axis=1) == truth).mean()
    answer = recognition.answer(log_posterior, np.zeros((300, 5)), clip, 5, Decision())
    assert 0.5 < frames < 0.8
    assert (answer.action == np.arange(5)).all()
