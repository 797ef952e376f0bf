"""GRIC: which model explains generated motions (research table), residuals that treat both pictures alike."""

import cv2
import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.models.gaze import gric
from ipcli.models.gaze.parameters import Keyframes

K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])


def matches(rng, parallax, planar=False, count=300, noise=0.5, outliers=0.1, turn=5.0):
    """Pixels of points 2 to 10 m away; `parallax` in pixels of what is 4 m away."""
    pixels = rng.uniform([0, 0], [640, 480], (count, 2))
    rays = np.concatenate([pixels, np.ones((count, 1))], axis=1) @ np.linalg.inv(K).T
    depth = 4 / (1 + 0.1 * rays[:, 0]) if planar else rng.uniform(2, 10, count)
    shift = np.array([parallax * 4 / 500, 0, 0])
    moved = (rays * depth[:, None]) @ lie.exp(np.radians([0, turn, 0])).T + shift
    second = (moved @ K.T)[:, :2] / moved[:, 2:]
    bad = rng.random(count) < outliers
    second[bad] = rng.uniform([0, 0], [640, 480], (int(bad.sum()), 2))
    return pixels + rng.normal(0, noise, (count, 2)), second + rng.normal(0, noise, (count, 2))


@pytest.mark.parametrize(
    ("parallax", "planar", "least", "most"),
    [
        (0.0, False, 0.0, 0.1),
        (0.6, False, 0.0, 0.1),
        (2.5, False, 0.85, 1.0),
        (6.2, False, 1.0, 1.0),
        (6.2, True, 0.0, 0.1),
    ],
)
def test_the_fundamental_matrix_is_chosen_when_the_head_moves(parallax, planar, least, most):
    chosen = [
        gric.motion(*matches(np.random.default_rng(seed), parallax, planar), 0.5).is_parallax for seed in range(20)
    ]
    assert least <= np.mean(chosen) <= most


def test_the_mean_differences_are_those_of_the_table():
    expected = {0.0: 77, 2.5: -74, 6.2: -251}  # research, mean GRIC(F) - GRIC(H) over scenes of its own
    for parallax, value in expected.items():
        found = [gric.motion(*matches(np.random.default_rng(seed), parallax), 0.5) for seed in range(20)]
        assert np.mean([m.score_f - m.score_h for m in found]) == pytest.approx(value, abs=60)


def test_one_sided_transfer_errors_choose_the_fundamental_matrix_for_a_pure_rotation():
    first, second = matches(np.random.default_rng(1), 0.0)
    found = gric.motion(first, second, 0.5)
    mapped = np.concatenate([first, np.ones((len(first), 1))], axis=1) @ found.homography.T
    one_sided = np.square(mapped[:, :2] / mapped[:, 2:] - second).sum(axis=1)
    assert gric.gric(one_sided, 0.5, gric.H_SHAPE) > found.score_f
    assert found.score_h < found.score_f


def test_sampson_distances_are_those_to_the_manifold():
    """For small errors the distance to the nearest pair that fits, found by a search."""
    from scipy.optimize import minimize

    h = np.array([[1.1, 0.02, 5], [-0.03, 0.95, 8], [1e-5, -2e-5, 1]])
    first = np.array([[100.0, 200.0]])
    mapped = h @ [100, 200, 1]
    second = (mapped[:2] / mapped[2])[None] + [[0.6, -0.4]]

    def off(x):
        m = h @ [x[0], x[1], 1]
        return np.square(x - first[0]).sum() + np.square(m[:2] / m[2] - second[0]).sum()

    best = minimize(off, first[0], tol=1e-12).fun
    assert gric.sampson_homography(h, first, second)[0] == pytest.approx(best, rel=1e-3)


def test_the_sampson_rule_does_not_depend_on_the_sign_of_f_and_the_printed_one_has_no_unit():
    first, second = matches(np.random.default_rng(3), 6.2)
    found = gric.motion(first, second, 0.5)
    before, now = np.array([320.0, 240]), np.array([330.0, 290])
    flipped = gric.FrameMotion(-2 * found.fundamental, found.homography, found.score_f, found.score_h, 300, 1.0)
    assert gric.change(found, before, now) == pytest.approx(gric.change(flipped, before, now))
    assert gric.change(found, before, now, "printed") == pytest.approx(gric.change(flipped, before, now, "printed"))


def test_a_change_must_last():
    p = Keyframes()
    assert not gric.wants_keyframe([False, True], False, p)
    assert gric.wants_keyframe([False, True, True], False, p)
    assert gric.wants_keyframe([], True, p)


def test_too_few_matches_say_nothing():
    found = gric.motion(np.zeros((4, 2)), np.zeros((4, 2)), 0.5)
    assert np.isnan(found.score_f)
    assert np.isnan(gric.change(found, np.zeros(2), np.zeros(2)))


@pytest.mark.parametrize("seed", [306, 454, 582, 1296, 1319])
def test_matches_on_which_opencv_fails_an_assertion_have_a_homography_and_no_fundamental_matrix(seed):
    """All but two are shifted alike, which any F with the right epipole explains: OpenCV 5.0 raises."""
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(0, 360, (int(rng.integers(16, 40)), 2))
    assert rng.integers(3) == 0
    moved = pixels + rng.uniform(-50, 50, 2) + rng.normal(0, 0.01, pixels.shape)
    bad = rng.random(len(pixels)) < rng.uniform(0, 0.9)
    moved[bad] = rng.uniform(0, 360, (bad.sum(), 2))
    found = gric.motion(pixels, moved, 0.5)
    assert np.isfinite(found.score_h)
    assert not found.is_parallax


def test_a_fit_that_opencv_gives_up_is_no_model(monkeypatch):
    def gives_up(*_):
        raise cv2.error("!model.empty()")

    monkeypatch.setattr(cv2, "findFundamentalMat", gives_up)
    monkeypatch.setattr(cv2, "findHomography", gives_up)
    found = gric.motion(*matches(np.random.default_rng(1), 2.5), 0.5)
    assert np.isnan([found.fundamental, found.homography]).all()
    assert np.isnan(gric.change(found, np.zeros(2), np.ones(2)))
