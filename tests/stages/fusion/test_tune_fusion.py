"""The error of methods against lambda, by its definition: what fusing at each lambda one by one gives."""

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.executor import ItemsFailed
from ipcli.io.files import h5
from ipcli.io.views import layouts
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import tune_fusion
from ipcli.stages.fusion.parameters import TuneFusion
from tests.fixtures.fusion_scenes import scene, write

SMALL = TuneFusion(methods=("tv-l1", "l1-adapt:ama", "median"), lambdas=(0.3, 0.05, 3.0))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("views")
    return [write(folder / f"{name}.views.h5", scene(seed=seed, shape=(48, 64))) for name, seed in (("a", 0), ("b", 1))]


@pytest.fixture(scope="module")
def tuned(files, tmp_path_factory):
    path = tmp_path_factory.mktemp("tuned") / "t.tuning.h5"
    tune_fusion.run(files, path, SMALL, Run())
    return path


def test_the_best_lambda_of_each_method_is_told(tuned):
    told, arrays = tune_fusion.summary(tuned), h5.read(tuned, "fusion-tuning").arrays
    assert told["best_lambda"] == dict(zip(["tv-l1", "l1-adapt (ama)"], arrays["best"], strict=True))
    assert (told["scenes"], told["measure"]) == (2, SMALL.measure)


def test_each_figure_is_that_of_the_method_at_that_lambda(files, tuned):
    arrays = h5.read(tuned, "fusion-tuning").arrays
    assert list(arrays["methods"]) == ["tv-l1", "l1-adapt (ama)"]
    assert list(arrays["scenes"]) == ["a", "b"]
    assert list(arrays["lambdas"]) == [0.05, 0.3, 3.0]
    sequence = layouts.open_views(files[1])
    views = [sequence.load(name) for name in sequence.names]
    alone = fuse(views, views[2], Fusion(method="l1-adapt", algorithm="ama", lam=0.3), inverse=False)
    seen = np.isfinite(views[2].truth) & (alone.observations > 0)
    rmse = np.sqrt(np.square(alone.depth - views[2].truth)[seen].mean())
    column = list(arrays["columns"]).index("RMSE")
    assert arrays["values"][1, 1, 1, column] == pytest.approx(
        rmse, rel=1e-3
    )  # it may lack pixels that another lambda lost
    assert arrays["automatic_lambda"] == pytest.approx(5**-0.5, rel=0.2)


def test_best_is_the_least_geometric_mean_over_the_scenes_and_is_what_others_read(tuned):
    arrays = h5.read(tuned, "fusion-tuning").arrays
    errors = arrays["values"][..., list(arrays["columns"]).index("RMSE")]
    for m, label in enumerate(arrays["methods"]):
        means = [np.sqrt(errors[0, m, n] * errors[1, m, n]) for n in range(3)]
        assert tune_fusion.read_best_lambdas(tuned)[str(label)] == arrays["lambdas"][int(np.argmin(means))]


def test_any_executor_gives_the_same_bytes(files, tuned, tmp_path):
    tune_fusion.run(files, tmp_path / "t.tuning.h5", SMALL, Run(executor="processes:2"))
    assert (tmp_path / "t.tuning.h5").read_bytes() == tuned.read_bytes()


def test_the_page_marks_a_best_lambda_at_an_end_of_the_grid(files, tmp_path):
    params = TuneFusion(methods=("tv-l1",), lambdas=(0.001, 0.002))
    tune_fusion.run(files[:1], tmp_path / "t.tuning.h5", params, Run())
    page = (tmp_path / "t.tuning.html").read_text()
    assert "end of the grid" in page
    assert "for 1 of 1" in page


@pytest.mark.parametrize(
    ("params", "message"),
    [
        (TuneFusion(methods=("median",)), "no method|none of these"),
        (TuneFusion(methods=("tgv",)), "unknown method 'tgv'; did you mean 'tgv-l1'"),
        (TuneFusion(methods=("tgv-l1:ama",)), "it estimates no confidence"),
        (TuneFusion(methods=("l1-adapt:amma",)), "expected one of acs, ama, biconvex"),
        (TuneFusion(lambdas=(0.1, 0.1)), "every lambda once"),
        (TuneFusion(fusion=Fusion(method="rof")), "name them by --methods"),
    ],
)
def test_what_makes_no_sense_is_refused(files, tmp_path, params, message):
    with pytest.raises(ParameterError, match=message):
        tune_fusion.run(files[:1], tmp_path / "t.h5", params, Run())


def test_an_unknown_measure_names_the_nearest_and_a_scene_without_truth_is_named(files, tmp_path):
    with pytest.raises(ParameterError, match="no measure 'RSME'; did you mean 'RMSE'"):
        tune_fusion.run(
            files[:1], tmp_path / "t.h5", TuneFusion(methods=("tv-l1",), lambdas=(0.3,), measure="RSME"), Run()
        )
    from dataclasses import replace

    blind = write(tmp_path / "c.views.h5", [replace(view, truth=None) for view in scene(shape=(48, 64))])
    with pytest.raises((FormatError, ItemsFailed), match=r"c\.views\.h5.*true depth of view '02' is not known"):
        tune_fusion.run([blind], tmp_path / "t.h5", SMALL, Run())
