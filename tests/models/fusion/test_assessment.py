"""What is said of a fused map, against plain definitions."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.inverse.regularize.parameters import Solver
from ipcli.models.fusion import assessment
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.metrics import ause
from ipcli.models.fusion.parameters import Fusion
from ipcli.models.fusion.scenes import EstimatedMap, Scene
from tests.fixtures.fusion_scenes import scene


@pytest.fixture(scope="module")
def views():
    return scene(shape=(30, 40))


@pytest.fixture(scope="module")
def fused(views):
    return fuse(views, views[2], Fusion(solver=Solver(iterations=100), reassociate=0), inverse=False)


def test_the_table_of_views_holds_their_shares_and_their_median_distance_from_the_map(views, fused):
    table = assessment.view_table(fused, [view.name for view in views], views)
    for k, view in enumerate(views):
        layer = fused.layers[k]
        assert table["view_valid"][k] == np.isfinite(view.depth).mean()
        assert table["view_overlap"][k] == np.isfinite(layer).mean()
        assert table["view_residual"][k] == pytest.approx(np.nanmedian(np.abs(layer - fused.depth)))
    assert list(table["views"]) == ["00", "01", "02", "03", "04"]


def test_a_view_that_reaches_nothing_has_no_residual_and_thumbnails_are_small(views, fused, monkeypatch):
    monkeypatch.setattr(assessment, "THUMBNAIL", 10)
    blind = replace(fused, layers=np.full_like(fused.layers, np.nan))
    table = assessment.view_table(blind, ["a"] * 5, views)
    assert np.isnan(table["view_residual"]).all()
    assert table["thumbnails"].shape == (5, 7, 10)


def test_errors_are_told_of_the_inputs_and_of_the_map_with_and_without_what_fills_it(views, fused):
    assert assessment.error_table(fused, replace(views[2], truth=None), None) == {}
    seen = fused.observations.copy()
    seen[:, :8] = 0
    found = assessment.error_table(replace(fused, observations=seen), views[2], None)
    assert list(found["metric_rows"]) == ["reference", "mean", "median", "fused", "fused, filled"]
    error = np.where(seen > 0, fused.depth, np.nan) - views[2].truth
    assert found["ause"] == pytest.approx(ause(fused.confidence, error))
    assert found["ause_uncertainty"] == pytest.approx(ause(-fused.uncertainty, error))


def test_a_map_without_confidence_has_no_curves_and_a_perfect_order_has_no_area(views, fused):
    views_and_truth = Scene(views, views[2], views[2].truth, False, None, "m")
    bare = EstimatedMap(fused.median)
    areas, curves = assessment.sparsification(bare, [bare], views_and_truth)
    assert np.isnan(areas).all()
    assert np.isnan(curves).all()
    assert curves.shape == (len(assessment.CURVES), assessment.SHARES)
    error = np.abs(fused.median - views[2].truth)
    perfect = EstimatedMap(fused.median, None, -error, error)
    areas, curves = assessment.sparsification(perfect, [perfect, bare], views_and_truth)
    assert areas[:2] == pytest.approx([0, 0])
    np.testing.assert_allclose(curves[:2], curves[[3, 3]])
    assert curves[:, -1] == pytest.approx(1)


def test_errors_of_a_large_map_are_measured_on_some_rows_and_columns(monkeypatch):
    views = scene(3, (96, 120))
    fused = fuse(views, views[1], Fusion(solver=Solver(iterations=60), rounds=1), inverse=False)
    whole = assessment.error_table(fused, views[1], None)
    monkeypatch.setattr(assessment, "thinning", lambda pixels: 2)
    some = assessment.error_table(fused, views[1], None)
    columns = list(whole["metric_columns"])
    for name, off in (("MAE", 0.2), ("density %", 0.01)):  # errors stand together at rims: a quarter of few pixels
        at = columns.index(name)
        np.testing.assert_allclose(some["metrics"][:, at], whole["metrics"][:, at], rtol=off)
    assert some["ause"] == pytest.approx(whole["ause"], rel=0.2)
    assert some["truth"].shape == whole["truth"].shape
