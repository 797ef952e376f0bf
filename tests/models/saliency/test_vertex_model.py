import numpy as np
import pytest

from ipcli.models.saliency import vertex_model
from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.models.saliency.vertex_features import SPACING, features
from tests.fixtures.fixation_sets import bumpy

QUICK = FixationLearning(trees=4, leaf=5)


@pytest.fixture(scope="module")
def cases():
    made = []
    for seed in range(3):
        points, normals, bump = bumpy(seed)
        made.append(vertex_model.SurfaceCase(f"s{seed}", features(points, normals), bump > 0.5, bump))
    return made


def test_a_bump_that_was_not_learnt_from_is_found(cases):
    predictor = vertex_model.learnt(cases[:2], QUICK, 0)
    row = vertex_model.judged("x", "model", [vertex_model.predicted(predictor, cases[2].features)], cases[2:])
    assert row.each[0, 0] > 0.95


def test_the_spacing_of_vertices_is_never_learnt_from(cases):
    for place in (True, False):
        names = vertex_model.columns(tuple(cases[0].features), place)
        assert not any(name.startswith(SPACING) for name in names)
    assert not any(
        name.startswith(("height", "faces")) for name in vertex_model.columns(tuple(cases[0].features), False)
    )


def test_rows_are_ranks_about_0_and_their_squares(cases):
    made = vertex_model.rows(cases[0].features, ("height", "height" + vertex_model.SQUARED))
    assert made[:, 0].mean() == pytest.approx(0, abs=1e-6)
    assert made[:, 1] == pytest.approx(made[:, 0] ** 2)


def test_the_weighted_auc_is_that_of_copies():
    rng = np.random.default_rng(0)
    values, hit = rng.integers(0, 6, 40).astype(float), rng.random(40) < 0.4
    weight = rng.integers(1, 4, 40)
    v, h = np.repeat(values, weight), np.repeat(hit, weight)
    pairs = np.sign(v[h][:, None] - v[~h][None, :])
    assert vertex_model.weighted_auc(values, hit, weight.astype(float)) == pytest.approx((pairs.mean() + 1) / 2)


def test_leave_one_out_has_a_fold_for_each(cases):
    maps = vertex_model.cross_validated(cases, QUICK, Validation(folds=10), 0)
    found = {row.name: row for row in vertex_model.worth(cases, maps)}
    assert found[vertex_model.FORMS[0]].each[:, 0].min() > 0.9
    assert found[SPACING].role == "baseline"
    assert found["height"].role == "feature"


def test_untrained_saliency_of_points_ranks_the_convex_first():
    points, normals, bump = bumpy(7)
    found = vertex_model.saliency(points, normals)
    assert found.mean() == pytest.approx(1, rel=1e-4)
    assert found[bump > 0.8].mean() > 1.2
