"""The whole fusion of generated scenes: what must not matter does not, and every method gains on its input."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.geometry.cameras import rays
from ipcli.geometry.surface import normals
from ipcli.inverse.regularize.fidelity import Observations
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.models.fusion.confidence import LEAST, view_angle
from ipcli.models.fusion.fuse import balanced_lambda, fuse, fuse_layers
from ipcli.models.fusion.metrics import ause, normal_error
from ipcli.models.fusion.parameters import METHODS, Confidence, Fusion
from ipcli.models.fusion.reprojection import reproject_all
from tests.fixtures.fusion_scenes import camera, cast, pose_at, scaled, scene

UNREGULARISED = ("mean", "median")
QUICK = Solver(iterations=500)


@cache
def with_a_blind_corner(outliers):
    """Five views that all miss a corner of the scene."""
    found = []
    for view in scene(outliers=outliers):
        depth = view.depth.copy()
        depth[:12, :16] = np.nan
        found.append(replace(view, depth=depth))
    return found


def views():
    return with_a_blind_corner(0.02)


def fused(views_, inverse=False, reference=2, **settings):
    return fuse(views_, views_[reference], Fusion(solver=QUICK, **settings), inverse=inverse)


def error(depth, view):
    return np.abs(depth - view.truth)


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
@pytest.mark.parametrize("method", [name for name in METHODS if name not in UNREGULARISED])
def test_every_method_is_nearer_to_the_truth_than_the_median_and_fills_the_holes(method, inverse):
    # outliers are not for squared deviations from all observations
    result = fused(with_a_blind_corner(0.0 if method == "rof" else 0.02), inverse, method=method)
    seen = result.observations > 0
    assert np.isfinite(result.depth).all()
    assert not seen.all()
    assert error(result.depth, views()[2])[seen].mean() < 0.85 * error(result.median, views()[2])[seen].mean()


@pytest.mark.parametrize("method", METHODS)
def test_the_confidence_is_0_exactly_where_nothing_was_observed(method):
    result = fused(views(), method=method)
    np.testing.assert_array_equal(result.confidence == 0, result.observations == 0)
    assert np.isfinite(result.confidence).all()
    np.testing.assert_array_equal(result.observations, np.isfinite(result.layers).sum(axis=0))
    np.testing.assert_array_equal(np.isnan(result.median), result.observations == 0)


def test_a_prior_confidence_divides_the_rate_where_the_surface_turns_away():
    """The wall faces the camera; at the rim of the ball the surface turns from it, and so does what is expected of the
    data.
    """
    layers = reproject_all(scene(), scene()[2])
    settings = Fusion(method="adapt-hprior", solver=QUICK)
    problem = fuse_layers(layers, scene()[2], settings, inverse=False).problem
    raised = problem.rate / settings.confidence.rate
    angle = view_angle(cast((60, 80), camera((60, 80)), scene()[2].cam_from_world), camera((60, 80)))
    assert raised.min() >= 1
    assert raised.max() <= 1 / LEAST + 1e-3
    assert np.median(np.abs(1 / raised - angle)) < 0.05
    assert raised[angle < 0.5].mean() > 1.3 * raised[angle > 0.9].mean()


@pytest.mark.parametrize("algorithm", ["ama", "biconvex"])
@pytest.mark.parametrize("method", [name for name in METHODS if METHODS[name].adaptive])
def test_each_algorithm_gives_nearly_the_same_depth(method, algorithm):
    one, other = (fused(views(), method=method, algorithm=name) for name in ("acs", algorithm))
    assert np.median(np.abs(one.depth - other.depth)) < 0.1 * one.noise_scale


def test_of_one_view_its_confidence_is_that_of_the_pixels():
    one, other = (fused(scene()[2:3], reference=0, method=method, lam=1.0) for method in ("l1-adapt", "l1-adapt-views"))
    np.testing.assert_allclose(other.depth, one.depth, atol=0.01 * one.noise_scale)
    np.testing.assert_allclose(other.confidence, one.confidence, rtol=1e-2)


def test_a_confidence_for_each_view_gains_where_a_patch_of_two_of_them_is_off():
    """Both are off by the same: absolute deviations alone move a third of the way from the median to them."""
    spoilt = [replace(view, depth=view.depth.copy()) for view in scene()]
    for view in spoilt[:2]:
        view.depth[30:50, 10:40] += np.float32(0.2)
    errors = {}
    for method in ("l1-adapt", "l1-adapt-views"):
        result = fused(spoilt, method=method)
        errors[method] = error(result.depth, spoilt[2])[30:50, 10:40].mean()
    assert errors["l1-adapt-views"] < 0.8 * errors["l1-adapt"]


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
@pytest.mark.parametrize("method", ["tgv-huber", "l1-adapt", "rof-adapt"])
def test_a_scene_in_millimetres_gives_a_thousand_times_the_map_in_metres(method, inverse):
    # so many iterations, always, that rounding does not decide when to stop
    settings = Fusion(method=method, rounds=2, solver=Solver(tolerance=0.0, iterations=1000))
    metres = fuse(views(), views()[2], settings, inverse=inverse)
    large = [scaled(view, 1000) for view in views()]
    millimetres = fuse(large, large[2], settings, inverse=inverse)
    np.testing.assert_array_equal(millimetres.observations, metres.observations)
    assert millimetres.noise_scale == pytest.approx(metres.noise_scale * (1e-3 if inverse else 1e3), rel=1e-4)
    apart = np.abs(millimetres.depth / 1000 - metres.depth)
    assert np.median(apart) < 1e-5
    assert np.quantile(apart, 0.99) < 1e-3
    np.testing.assert_allclose(np.median(millimetres.confidence), np.median(metres.confidence), rtol=1e-3)


@pytest.mark.parametrize("method", ["median", "tgv-l1", "l1-adapt"])
def test_the_order_of_the_views_does_not_matter(method):
    forth = fused(views(), method=method)
    back = fuse(views()[::-1], views()[2], Fusion(solver=QUICK, method=method), inverse=False)
    np.testing.assert_allclose(back.depth, forth.depth, atol=1e-5)
    np.testing.assert_allclose(back.confidence, forth.confidence, rtol=1e-4, atol=1e-6)
    np.testing.assert_array_equal(back.layers[::-1], forth.layers)


@pytest.mark.parametrize("method", METHODS)
def test_one_view_alone_is_fused_too(method):
    # lambda weighs one observation here where it weighed five
    result = fused(scene()[2:3], reference=0, method=method, lam=1.0)
    own = scene()[2]
    seen = np.isfinite(own.depth)
    np.testing.assert_array_equal(result.observations > 0, seen)
    np.testing.assert_allclose(result.median[seen], own.depth[seen], rtol=1e-5)
    assert result.noise_scale == pytest.approx(0.02, rel=0.35)
    if method not in UNREGULARISED:
        assert error(result.depth, own)[seen].mean() < 0.8 * error(own.depth, own)[seen].mean()


def weighted(views_, values):
    shape = views_[0].depth.shape
    return [
        replace(view, confidence=np.full(shape, value, np.float32)) for view, value in zip(views_, values, strict=True)
    ]


@pytest.mark.parametrize("method", ["mean", "tgv-l1", "l1-adapt"])
def test_a_view_of_confidence_0_does_not_count(method):
    """The scale of the noise is measured without the confidences, so it is the same only for sound views."""
    spoilt = [*views()[:4], replace(views()[4], depth=views()[4].depth * np.float32(0.8))]
    with_0 = fused(weighted(spoilt, [1, 1, 1, 1, 0]), method=method)
    without = fused(views()[:4], method=method)
    assert np.abs(with_0.depth - without.depth)[without.observations > 0].mean() < 0.2 * without.noise_scale
    np.testing.assert_array_equal(with_0.observations, without.observations)
    np.testing.assert_allclose(with_0.median, without.median, rtol=1e-5)


def test_given_confidences_are_ignored_on_request():
    ignored = fused(weighted(views(), [1, 0, 5, 0, 2]), confidence=Confidence(given=False))
    np.testing.assert_array_equal(ignored.depth, fused(views()).depth)


def test_only_the_ratio_of_given_confidences_to_lambda_matters():
    one = fused(weighted(views(), [1, 2, 1, 0.5, 1]), method="tgv-l1", lam=0.4)
    other = fused(weighted(views(), [2, 4, 2, 1, 2]), method="tgv-l1", lam=0.2)
    assert np.quantile(np.abs(one.depth - other.depth), 0.99) < 0.1 * one.noise_scale


def test_good_confidences_gain_on_even_ones():
    """Views of very different noise: weights that tell of it must help."""
    mixed = [scene(noise=n, seed=s)[i] for i, (n, s) in enumerate([(0.01, 1), (0.1, 2), (0.01, 3), (0.1, 4), (0.1, 5)])]
    even = fused(mixed, method="tgv-l1")
    told = fused(weighted(mixed, [1, 0.1, 1, 0.1, 0.1]), method="tgv-l1", lam=0.6)
    assert error(told.depth, mixed[2]).mean() < 0.8 * error(even.depth, mixed[2]).mean()


def test_a_slanted_plane_is_affine_in_disparity_and_not_in_depth():
    shape = (60, 80)
    k = camera(shape)
    inverse_depth = rays(shape, k) @ [0.6, 0.0, 1.0] / 2
    rng = np.random.default_rng(0)
    own = replace(scene(1)[0], intrinsics=k, cam_from_world=pose_at((0, 0, 0)))
    same = [
        replace(own, depth=(1 / (inverse_depth + rng.laplace(0, 0.005, shape))).astype(np.float32)) for _ in range(5)
    ]
    apart = {
        name: fuse(same, own, Fusion(method="tgv-l1", lam=0.003), inverse=name == "disparity").depth * inverse_depth - 1
        for name in ("depth", "disparity")
    }
    assert 5 * np.abs(apart["disparity"]).mean() < np.abs(apart["depth"]).mean()


@pytest.mark.parametrize("method", ["median", "rof", "l1-adapt"])
def test_confidences_that_are_all_0_and_views_that_look_away_have_no_solution(method):
    with pytest.raises(NoSolution, match="confidence of every observation is 0"):
        fused(weighted(views(), [0] * 5), method=method)
    away = replace(views()[0], cam_from_world=pose_at((0, 0, 0), np.pi))
    blind = replace(views()[2], depth=np.full_like(views()[2].depth, np.nan))
    with pytest.raises(NoSolution, match="no view has a valid depth"):
        fuse([away, blind], blind, Fusion(method=method), inverse=False)


def test_the_same_views_give_the_same_bits():
    one, other = fused(views()), fused(views())
    for field in ("depth", "confidence", "history", "layers"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))


@pytest.mark.parametrize("k", [1, 4, 9])
def test_the_automatic_lambda_is_one_over_the_square_root_of_the_number_of_views(k):
    layers = np.zeros((k, 5, 6), np.float32)
    assert balanced_lambda(Observations.of(layers), METHODS["tgv-l1"]) == pytest.approx(k**-0.5)
    assert balanced_lambda(Observations.of(layers), METHODS["rof-median"]) == pytest.approx(k**0.5)


def test_the_automatic_lambda_is_that_of_the_median_observation_whatever_few_views_see_around():
    """Four views cover the middle of the image, one alone the rest, twice as many pixels."""
    layers = np.full((4, 6, 10), np.nan, np.float32)
    layers[0] = 1.0
    layers[:, :2] = 1.0
    assert balanced_lambda(Observations.of(layers), METHODS["tgv-l1"]) == 0.5


def test_the_automatic_lambda_makes_the_scale_of_given_confidences_mean_nothing():
    one = fused(weighted(views(), [1, 2, 1, 0.5, 1]), method="tgv-l1")
    other = fused(weighted(views(), [100, 200, 100, 50, 100]), method="tgv-l1")
    assert np.quantile(np.abs(one.depth - other.depth), 0.99) < 0.1 * one.noise_scale


# alpha0 = 3, the default, serves disparities of real scenes: in this one the confidence then errs less, not the
# uncertainty more (measured shares .33 and .83, and .34 and .58 at alpha0 = 2).
@pytest.mark.parametrize(
    ("inverse", "alpha0", "share"), [(False, 3.0, 0.4), (True, 3.0, 0.85), (False, 2.0, 0.4), (True, 2.0, 0.65)]
)
def test_the_uncertainty_orders_the_errors_better_than_the_confidence_does_and_about_as_the_angle_in_a_smooth_scene(
    inverse, alpha0, share
):
    result, reference = fused(views(), inverse, regulariser=Regulariser(alpha0=alpha0)), views()[2]
    error = np.where(result.observations > 0, result.depth, np.nan) - reference.truth
    angle = view_angle(result.depth, reference.intrinsics)
    own = ause(-result.uncertainty, error)
    assert own < share * ause(result.confidence, error)
    assert own < 1.1 * ause(angle, error)


@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_the_normals_of_the_slopes_are_nearer_to_the_truth_than_those_of_the_median(inverse):
    result, reference = fused(views(), inverse), views()[2]
    true, seen = normals(reference.truth, reference.intrinsics), result.observations > 0
    own, median = (normal_error(n, true, seen) for n in (result.normals, normals(result.median, reference.intrinsics)))
    assert own < 0.25 * median
