"""The judge of rims: recovers a known rule, and tells a shaded ball from a bent sheet."""

import numpy as np

from ipcli.models.brdf import rim, solid, surfaces


def test_a_logistic_rule_is_learnt():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(4000, 3))
    p = 1 / (1 + np.exp(-(2 * x[:, 0] - x[:, 1])))
    labels = (rng.uniform(size=4000) < p).astype(float)
    judged = rim.learn(x, labels).sheet(x)
    assert np.abs(judged - p).mean() < 0.03
    bayes = ((p > 0.5) == (labels > 0.5)).mean()
    assert abs(rim.accuracy(x, labels) - bayes) < 0.01


def test_flat_truth_is_served_by_the_flattened_balloon_and_a_ball_by_the_balloon():
    ball = surfaces.march(surfaces.ellipsoid(np.full(3, 0.8)), 60)
    assert not rim.better_as_sheet(ball.mask, ball.normals, 0.3)
    assert rim.better_as_sheet(ball.mask, np.tile([0, 0, 1.0], (60, 60, 1)), 0.3)


def test_features_tell_corners_and_the_light_of_a_ball():
    ball = surfaces.march(surfaces.ellipsoid(np.full(3, 0.8)), 80)
    shade = np.nan_to_num(np.clip(ball.normals @ np.array([0.3, 0.4, 0.85]), 0, 1))
    of_ball = dict(
        zip(
            rim.FEATURES,
            rim.features(solid.pictured(np.repeat(shade[..., None], 3, axis=-1), ball.mask, 60)),
            strict=True,
        )
    )
    card = np.ones((50, 70), bool)
    slant = np.repeat(np.linspace(0.4, 0.8, 70)[None, :, None], 50, axis=0) * np.ones(3)
    of_card = dict(zip(rim.FEATURES, rim.features(solid.pictured(slant, card, 60)), strict=True))
    assert of_ball["shading explained by light"] > 0.9
    assert of_card["straight share"] > 0.9
    assert of_ball["straight share"] < of_card["straight share"] - 0.3
    assert of_card["corner share"] > 0.9
    assert of_card["rectangularity"] > of_ball["rectangularity"] + 0.1
