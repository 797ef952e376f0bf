"""The whole inference on a generated potato: rim as told, reliefs that mirror, what is reported."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.brdf import evaluation, grid, surfaces
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.material import STATISTICS, Classifier
from ipcli.models.brdf.parameters import Inference, Patches
from ipcli.models.brdf.reconstruct import baselines, reconstruct
from ipcli.models.brdf.reflectance import Harmonics, chart_normals
from ipcli.models.brdf.rim import FEATURES, Judge

LIGHT = np.array([0.4, -0.25, 0.3, 0.35, 0, 0, 0, 0, 0])


def shelf():
    n = chart_normals().reshape(-1, 3)
    lights = (LIGHT, np.array([0.4, 0.3, 0.3, 0.35, 0, 0, 0, 0, 0]), np.array([0.3, 0, -0.4, 0.5, 0, 0, 0, 0, 0]))
    made = np.stack(
        [np.repeat(np.maximum(Harmonics(c).slopes(n)[0], 0.01).reshape(65, 65, 1), 3, axis=-1) for c in lights]
    )
    f, m = len(FEATURES), len(STATISTICS)
    judge = Judge(np.zeros(1 + 2 * f), np.zeros(f), np.ones(f))  # undecided
    classifier = Classifier(np.zeros((m, 2)), np.log([0.25, 0.75]), np.zeros(m), np.ones(m), 1.0)
    return Library(made, np.array([0, 0, 1]), np.array([0, 1, 1]), ("a", "b"), ("p", "q"), judge, classifier)


@pytest.fixture(scope="module")
def scene():
    rng = np.random.default_rng(2)
    body = surfaces.bumpy(
        surfaces.ellipsoid(np.array([0.85, 0.6, 0.45])), rng.normal(0, 3, (4, 3)), rng.uniform(0, 6, 4), 0.08
    )
    made = surfaces.march(body, 90)
    colour = np.zeros((90, 90, 3))
    colour[made.mask] = np.maximum(Harmonics(LIGHT).slopes(made.normals[made.mask])[0], 0)[:, None]
    rows, columns = (np.flatnonzero(made.mask.any(axis=axis)) for axis in (1, 0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return colour[box], made.mask[box], made.normals[box]


def error(height, scene):
    return evaluation.normal_error(grid.normals(np.nan_to_num(height), scene[1]), scene[2], evaluation.inside(scene[1]))


QUICK = Inference(side=40, sweep_side=24, use_patches="none")


def test_an_undecided_judge_gives_both_answers_and_their_mean(scene):
    made = reconstruct(scene[0], scene[1], shelf(), QUICK)
    assert made.sheet == 0.5
    np.testing.assert_allclose(made.height, 0.5 * made.solid_height + 0.5 * made.sheet_height, atol=1e-9)
    assert made.material_posterior(shelf()).sum() == pytest.approx(1)
    assert made.probe_posterior(shelf()).sum() == pytest.approx(1)
    assert (made.confidence[scene[1]] <= 1 + 1e-9).all()


def test_a_solid_beats_its_balloon_and_needs_no_maps(scene):
    made = reconstruct(scene[0], scene[1], shelf(), replace(QUICK, rim="solid"))
    assert made.sheet_height is None
    assert error(made.height, scene) < 0.85 * error(baselines(scene[1])["inflation"], scene)
    assert np.isnan(made.probe_posterior(shelf())).all()
    np.testing.assert_allclose(made.material_posterior(shelf()), [0.25, 0.75])


def test_patches_move_a_solid_and_it_still_beats_its_balloon(scene):
    asked = replace(QUICK, rim="solid", patches=Patches(surfaces=8, each=60))
    alone, told = (
        reconstruct(scene[0], scene[1], shelf(), replace(asked, use_patches=use)) for use in ("none", "prior")
    )
    assert np.nanmax(np.abs(told.height - alone.height)) > 0.1
    assert error(told.height, scene) < 0.8 * error(baselines(scene[1])["inflation"], scene)
    assert np.isfinite(told.height[scene[1]]).all()


def test_one_picture_does_not_tell_convex_from_concave_and_says_so(scene):
    convex, concave = (
        reconstruct(scene[0], scene[1], shelf(), replace(QUICK, rim="solid", relief=r)) for r in ("convex", "concave")
    )
    assert abs(convex.tie) < 0.02
    inner = np.isfinite(convex.height)
    assert np.corrcoef(convex.height[inner], concave.height[inner])[0, 1] < -0.95
    assert convex.is_above
    assert not concave.is_above


def test_a_sheet_that_is_said_to_be_hollow_sets_out_hollow(scene):
    cast = scene[2] * [-1, -1, 1]  # what the object leaves in clay, under the first light of the library
    colour = np.zeros_like(scene[0])
    colour[scene[1]] = np.maximum(Harmonics(LIGHT).slopes(cast[scene[1]])[0], 0)[:, None]
    convex, concave = (
        reconstruct(colour, scene[1], shelf(), replace(QUICK, rim="sheet", relief=r)) for r in ("convex", "concave")
    )
    np.testing.assert_allclose(concave.prior, -convex.prior)
    assert error(concave.height, (colour, scene[1], cast)) < 0.8 * error(convex.height, (colour, scene[1], cast))


def test_light_above_chooses_the_relief_whose_light_is(scene):
    flipped = scene[0][::-1], scene[1][::-1], scene[2][::-1] * [1, -1, 1]  # the same object lit from below
    made = reconstruct(flipped[0], flipped[1], shelf(), replace(QUICK, rim="solid", relief="light-above"))
    assert made.is_above
    assert np.nanmedian(made.prior) < 0


def test_the_convex_refinement_keeps_to_the_surface(scene):
    plain = reconstruct(scene[0], scene[1], shelf(), replace(QUICK, rim="solid"))
    refined = reconstruct(scene[0], scene[1], shelf(), replace(QUICK, rim="solid", refine="convex"))
    assert error(refined.height, scene) < error(baselines(scene[1])["inflation"], scene)
    assert np.abs(plain.height - refined.height)[scene[1]].max() > 1e-3
