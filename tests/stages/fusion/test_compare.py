"""One table of the errors of several fused maps."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import h5
from ipcli.io.views import artefact
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import compare, fuse_depth
from ipcli.stages.fusion.parameters import CompareFusion, FuseDepth
from tests.fixtures.fusion_scenes import scene

PARAMS = FuseDepth(fusion=Fusion(method="tgv-l1"))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Two scenes, each fused by two methods; and a map without a truth."""
    folder = tmp_path_factory.mktemp("fused")
    made = []
    for name, seed in (("a", 0), ("b", 1)):
        views = folder / f"{name}.views.h5"
        h5.write(views, "views", artefact.views_arrays(scene(seed=seed), unit="m", measured="depth"), {})
        for method in ("median", "tgv-l1"):
            made.append(folder / f"{name}.{method}.h5")
            fuse_depth.run(views, made[-1], replace(PARAMS, fusion=Fusion(method=method)), Run())
    blind = [replace(view, truth=None) for view in scene()]
    h5.write(folder / "c.views.h5", "views", artefact.views_arrays(blind, unit="m", measured="depth"), {})
    fuse_depth.run(folder / "c.views.h5", folder / "c.fused.h5", PARAMS, Run())
    return made


def test_a_table_holds_what_each_file_says_of_its_scene_and_method(files, tmp_path):
    compare.run(files, tmp_path / "t.h5", CompareFusion(), Run())
    table = h5.read(tmp_path / "t.h5", "fusion-comparison").arrays
    assert list(table["scenes"]) == ["a", "b"]
    for path in files:
        one = h5.read(path, "fused-depth").arrays
        scene_index = list(table["scenes"]).index(path.name[0])
        method = list(table["methods"]).index(one["method"])
        np.testing.assert_array_equal(
            table["values"][scene_index, method], one["metrics"][list(one["metric_rows"]).index("fused")]
        )


def test_the_csv_and_the_page_give_the_same_figures(files, tmp_path):
    compare.run(files, tmp_path / "t.h5", CompareFusion(), Run())
    table = h5.read(tmp_path / "t.h5", "fusion-comparison").arrays
    lines = list(csv.reader((tmp_path / "t.csv").read_text().splitlines()))
    assert lines[0] == ["scene", "method", *table["columns"]]
    np.testing.assert_array_equal(
        np.array([line[2:] for line in lines[1:]], float), table["values"].reshape(-1, table["values"].shape[2])
    )
    page = (tmp_path / "t.html").read_text()
    assert all(str(name) in page for name in (*table["scenes"], *table["methods"], *table["columns"]))


def test_a_map_without_truth_is_refused_by_name(files, tmp_path):
    blind = files[0].parent / "c.fused.h5"
    with pytest.raises(FormatError, match=r"c\.fused\.h5.*no error measures"):
        compare.run([*files, blind], tmp_path / "t.h5", CompareFusion(), Run())


def test_two_figures_for_one_cell_are_refused(files, tmp_path):
    other = tmp_path / "a.other.h5"
    other.write_bytes(files[3].read_bytes())  # scene b under the name of scene a
    with pytest.raises(ParameterError, match="other figures"):
        compare.run([files[1], other], tmp_path / "t.h5", CompareFusion(), Run())


def test_the_best_methods_are_named_with_their_figures():
    from ipcli.stages.fusion.compare import best_methods

    values = np.array([[2.0, 0.5], [1.0, np.nan], [np.nan, 0.25]])
    found = best_methods(["a", "b", "c"], ["RMSE", "N-MAE rad"], values)
    assert found["best_by_rmse"].value == {"method": "b", "value": 1.0}
    assert found["best_by_n_mae"].value == {"method": "c", "value": 0.25}
    assert best_methods(["a"], ["out-3 %"], values[:1, :1]) == {}
