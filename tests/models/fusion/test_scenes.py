"""Methods tried on a scene of known truth, without files."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.inverse.regularize.parameters import Solver
from ipcli.models.fusion.metrics import compare
from ipcli.models.fusion.parameters import Fusion, Variant
from ipcli.models.fusion.scenes import INITIAL, EstimatedMap, Scene, best_lambdas, run_trials, sweep_lambdas
from tests.fixtures.fusion_scenes import scene

QUICK = Fusion(solver=Solver(iterations=100), reassociate=0)
VARIANTS = [Variant("tv-l1", None), Variant("median", None), Variant("tgv-l1", None)]


@pytest.fixture(scope="module")
def wall_and_ball():
    views = scene(shape=(30, 40))
    return Scene(views, views[2], views[2].truth, False, None, "m")


def test_trials_are_the_initial_maps_and_then_each_regularised_method_by_each_rule(wall_and_ball):
    told = []
    trials = run_trials(
        wall_and_ball, VARIANTS, QUICK, {"tgv-l1": 0.7, "rof": 1.0}, lambda share, _: told.append(share)
    )
    assert [(trial.label, trial.rule) for trial in trials] == [
        *((name, "none") for name in INITIAL),
        ("tv-l1", "automatic"),
        ("tgv-l1", "automatic"),
        ("tgv-l1", "tuned"),
    ]
    assert trials[-1].lam == 0.7
    assert np.isnan([trial.lam for trial in trials[:3]]).all()
    assert told == pytest.approx([1 / 3, 2 / 3, 1])
    alone = wall_and_ball.fuse(Variant("tgv-l1", None), QUICK, 0.7)
    np.testing.assert_array_equal(trials[-1].map.depth, EstimatedMap.of(alone).depth)


def test_what_was_in_painted_is_no_part_of_an_estimated_map(wall_and_ball):
    fused = wall_and_ball.fuse(VARIANTS[0], QUICK)
    blind = replace(fused, observations=np.where(np.arange(40) < 5, 0, fused.observations))
    found = EstimatedMap.of(blind)
    assert np.isnan(found.depth[:, :5]).all()
    np.testing.assert_array_equal(np.isnan(found.depth), blind.observations == 0)
    assert not EstimatedMap(found.depth).confidence_or_zero.any()


def test_a_sweep_holds_the_errors_of_each_lambda_on_the_pixels_that_all_have(wall_and_ball):
    swept = sweep_lambdas(wall_and_ball, VARIANTS, QUICK, [0.1, 1.0])
    assert swept["values"].shape == (2, 2, len(swept["columns"]))
    assert swept["automatic"].shape == (2, len(swept["columns"]))
    maps = [EstimatedMap.of(wall_and_ball.fuse(VARIANTS[2], QUICK, lam)) for lam in (None, 0.1, 1.0)]
    truth, intrinsics = wall_and_ball.truth, wall_and_ball.reference.intrinsics
    named = {str(index): one for index, one in enumerate(maps)}
    depths, own = ({name: getattr(one, field) for name, one in named.items()} for field in ("depth", "normals"))
    columns, rows = compare(depths, truth, intrinsics, None, own)
    assert list(swept["columns"]) == columns
    np.testing.assert_array_equal(np.vstack([swept["automatic"][1], *swept["values"][1]]), rows)


def test_the_best_lambda_is_that_of_the_least_mean_over_the_scenes():
    rmse = np.array([[[3.0, 1.0, 2.0]], [[1.0, 2.0, 0.1]]])  # one method, three lambdas, two scenes
    values = np.stack([rmse, -rmse], axis=-1)
    lambdas = np.array([0.1, 0.2, 0.4])
    np.testing.assert_array_equal(best_lambdas(values, ["RMSE", "other"], "RMSE", lambdas), [0.4])
    with pytest.raises(ParameterError, match="no measure 'RSME'; did you mean 'RMSE'"):
        best_lambdas(values, ["RMSE", "other"], "RSME", lambdas)
