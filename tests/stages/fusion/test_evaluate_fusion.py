"""All methods on one scene: the figures of fuse-depth, by both rules for lambda."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import ParameterError
from ipcli.geometry.surface import normals
from ipcli.io.files import h5
from ipcli.models.fusion.metrics import ause, normal_error
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import compare, evaluate_fusion, fuse_depth, tune_fusion
from ipcli.stages.fusion.parameters import CompareFusion, EvaluateFusion, FuseDepth, TuneFusion
from ipcli.stages.kit.artefact import Outcome
from tests.fixtures.fusion_scenes import scene, write

METHODS = ("tv-l1", "l1-adapt", "mean")


@pytest.fixture(scope="module")
def views(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "a.views.h5", scene(shape=(48, 64)))


@pytest.fixture(scope="module")
def tuning(views):
    path = views.with_name("t.tuning.h5")
    tune_fusion.run([views], path, TuneFusion(methods=("tv-l1",), lambdas=(0.2, 1.5)), Run())
    return path


@pytest.fixture(scope="module")
def evaluated(views, tuning):
    path = views.with_name("a.trials.h5")
    evaluate_fusion.run(views, path, EvaluateFusion(methods=METHODS), Run(), tuning)
    return path


def test_rows_are_the_given_maps_and_each_method_by_each_rule_there_is(evaluated, tuning):
    arrays = h5.read(evaluated, "fusion-trials").arrays
    schema.validate(schema.kind("fusion-trials"), arrays)
    rows = list(zip(arrays["methods"], arrays["rules"], strict=True))
    assert rows == [
        ("reference", "none"),
        ("mean", "none"),
        ("median", "none"),
        ("tv-l1", "automatic"),
        ("tv-l1", "tuned"),
        ("l1-adapt (acs)", "automatic"),
    ]
    assert arrays["lambdas"][4] == tune_fusion.read_best_lambdas(tuning)["tv-l1"]
    assert np.isnan(arrays["lambdas"][:3]).all()


def test_the_maps_are_those_of_fuse_depth(views, evaluated, tmp_path):
    arrays = h5.read(evaluated, "fusion-trials").arrays
    fuse_depth.run(views, tmp_path / "f.h5", FuseDepth(fusion=Fusion(method="l1-adapt")), Run())
    alone = h5.read(tmp_path / "f.h5", "fused-depth").arrays
    kept = list(arrays["maps"]).index("l1-adapt (acs)")
    np.testing.assert_array_equal(arrays["depth"][kept], np.where(alone["observations"] > 0, alone["depth"], np.nan))
    np.testing.assert_array_equal(arrays["confidence"][kept], alone["confidence"])
    np.testing.assert_array_equal(arrays["depth"][list(arrays["maps"]).index("median")], alone["median"])


def test_the_curves_end_at_the_mean_error_and_enclose_the_ause(evaluated):
    arrays = h5.read(evaluated, "fusion-trials").arrays
    row = list(arrays["methods"]).index("l1-adapt (acs)")
    kept, least = arrays["kept_error"][row], arrays["least_error"][row]
    assert kept[-1] == pytest.approx(1)
    assert least[-1] == pytest.approx(1)
    assert (np.diff(least) >= 0).all()
    assert (least <= kept + 1e-9).all()
    area = arrays["values"][row, list(arrays["columns"]).index("AUSE confidence")]
    assert (kept - least).mean() == pytest.approx(area, rel=0.1)
    index = list(arrays["maps"]).index("l1-adapt (acs)")
    known = np.isfinite(arrays["depth"]).all(axis=0)
    error = np.where(known, np.abs(arrays["depth"][index] - arrays["truth"]), np.nan)
    assert area == pytest.approx(ause(arrays["confidence"][index], error))


def test_normals_and_uncertainty_are_judged_as_fuse_depth_judges_them(views, evaluated, tmp_path):
    arrays = h5.read(evaluated, "fusion-trials").arrays
    fuse_depth.run(views, tmp_path / "f.h5", FuseDepth(fusion=Fusion(method="l1-adapt")), Run())
    alone = h5.read(tmp_path / "f.h5", "fused-depth").arrays
    error = np.where(np.isfinite(arrays["depth"]).all(axis=0), np.abs(alone["depth"] - alone["truth"]), np.nan)
    row, columns = list(arrays["methods"]).index("l1-adapt (acs)"), list(arrays["columns"])
    by_uncertainty, by_angle = (
        arrays["values"][row, columns.index(f"AUSE {order}")] for order in ("uncertainty", "angle")
    )
    assert by_uncertainty == pytest.approx(ause(-alone["uncertainty"], error))
    assert by_uncertainty != pytest.approx(by_angle)
    common = np.isfinite(error) & np.isfinite(arrays["truth"])
    angle = normal_error(alone["normals"], normals(alone["truth"], alone["intrinsics"]), common)
    assert arrays["values"][row, columns.index("N-MAE rad")] == pytest.approx(angle)
    error, uncertainty = error[common].astype(float), alone["uncertainty"][common]
    counts = np.arange(1, 41) * len(error) / 40
    for field, key in (("kept_error_uncertainty", uncertainty), ("least_error", error)):
        means = np.cumsum(error[np.argsort(key, kind="stable")]) / np.arange(1, len(error) + 1) / error.mean()
        kept = np.interp(counts, np.arange(1, len(error) + 1), means)
        np.testing.assert_allclose(arrays[field][row], kept, rtol=0.02)  # a pixel more or less: .011 at the first share


def test_compare_joins_trials_and_tells_the_rules_apart(evaluated, tmp_path):
    other = tmp_path / "b.trials.h5"
    other.write_bytes(evaluated.read_bytes())
    compare.run([evaluated, other], tmp_path / "t.h5", CompareFusion(), Run())
    table, one = h5.read(tmp_path / "t.h5", "fusion-comparison").arrays, h5.read(evaluated, "fusion-trials").arrays
    assert list(table["scenes"]) == ["a", "b"]
    assert list(table["methods"])[3:5] == ["tv-l1", "tv-l1, tuned λ"]
    np.testing.assert_array_equal(table["values"][1], one["values"])


def test_a_second_run_is_up_to_date_until_the_tuning_changes(views, tuning, evaluated, tmp_path):
    assert evaluate_fusion.run(views, evaluated, EvaluateFusion(methods=METHODS), Run(), tuning) is Outcome.UP_TO_DATE
    again = tmp_path / "t.tuning.h5"
    tune_fusion.run([views], again, TuneFusion(methods=("tv-l1",), lambdas=(0.3, 1.5)), Run())
    assert (
        evaluate_fusion.run(views, evaluated, EvaluateFusion(methods=METHODS), Run(overwrite=True, dry_run=True), again)
        is Outcome.WOULD_RUN
    )


def test_the_page_shows_every_row_and_every_kept_map(evaluated):
    page = evaluated.with_suffix(".html").read_text()
    assert "tv-l1, tuned λ" in page
    assert "l1-adapt (acs): error" in page
    assert "share of pixels kept" in page


def test_the_given_maps_alone_can_be_asked_for(views, tmp_path):
    evaluate_fusion.run(views, tmp_path / "a.h5", EvaluateFusion(methods=("median",)), Run())
    assert list(h5.read(tmp_path / "a.h5", "fusion-trials").arrays["methods"]) == ["reference", "mean", "median"]


def test_a_lambda_for_all_methods_is_refused(views, tmp_path):
    with pytest.raises(ParameterError, match=r"leave out fusion\.lam"):
        evaluate_fusion.run(views, tmp_path / "a.h5", EvaluateFusion(fusion=Fusion(lam=0.3)), Run())
