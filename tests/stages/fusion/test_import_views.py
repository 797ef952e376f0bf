from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import OutputExists, ParameterError
from ipcli.io.files import h5
from ipcli.io.views import artefact, layouts
from ipcli.measurements.views import View
from ipcli.params import Run
from ipcli.stages.fusion import import_views
from ipcli.stages.fusion.import_views import select_names
from ipcli.stages.fusion.parameters import ImportViews
from ipcli.stages.kit.artefact import Outcome

CAMERA = np.array([[50.0, 0, 31.5], [0, 50.0, 23.5], [0, 0, 1]])
NAMES = tuple("abcde")


def source(path: Path, measured: str = "depth") -> Path:
    """Five views of a wall at 2 m, with a hole."""
    depth = np.full((48, 64), 2.0, np.float32)
    depth[:4] = np.nan
    views = [View(name, depth, CAMERA, np.eye(4)) for name in NAMES]
    h5.write(path, "views", artefact.views_arrays(views, unit="m", measured=measured, baseline_focal=40.0), {})
    return path


def run(tmp_path: Path, params: ImportViews, how: Run = Run(), measured: str = "depth"):
    output = tmp_path / "out.views.h5"
    outcome = import_views.run(source(tmp_path / "in.h5", measured), output, params, how)
    return outcome, layouts.open_views(output)


def test_without_wishes_the_views_are_copied(tmp_path):
    outcome, copy = run(tmp_path, ImportViews())
    original = layouts.open_views(tmp_path / "in.h5")
    assert outcome is Outcome.DONE
    assert copy.names == NAMES
    assert copy.baseline_focal == 40.0
    for name in NAMES:
        np.testing.assert_array_equal(copy.load(name).depth, original.load(name).depth)
        assert copy.load(name).truth is None


def test_noise_keeps_the_clean_depth_as_truth(tmp_path):
    _, noisy = run(tmp_path, ImportViews(noise="laplace:0.03"))
    view = noisy.load("a")
    np.testing.assert_array_equal(view.truth[4:], 2.0)
    assert np.isnan(view.depth[:4]).all()
    assert np.isnan(view.truth[:4]).all()
    assert np.mean(np.abs(view.depth[4:] - 2.0)) == pytest.approx(0.03, rel=0.1)


def test_noise_of_a_view_depends_on_its_name_and_the_seed_alone(tmp_path):
    def depth(params: ImportViews, seed: int = 0) -> np.ndarray:
        return run(tmp_path, params, Run(seed=seed, overwrite=True))[1].load("c").depth

    all_views = depth(ImportViews(noise="gauss:0.1"))
    np.testing.assert_array_equal(depth(ImportViews(noise="gauss:0.1", views="c")), all_views)
    assert not np.array_equal(depth(ImportViews(noise="gauss:0.1", views="c"), seed=1), all_views, equal_nan=True)
    both = run(tmp_path, ImportViews(noise="gauss:0.1"), Run(overwrite=True))[1]
    assert not np.array_equal(both.load("a").depth, both.load("b").depth, equal_nan=True)


def test_noise_of_disparities_is_added_to_disparities(tmp_path):
    _, noisy = run(tmp_path, ImportViews(noise="gauss:0.5", views="a"), measured="disparity")
    disparity = 40.0 / noisy.load("a").depth[4:]
    assert disparity.mean() == pytest.approx(20.0, abs=0.05)
    assert disparity.std() == pytest.approx(0.5, rel=0.05)


def test_a_truth_that_is_known_is_kept(tmp_path):
    clean = View("a", np.full((8, 8), 2.0, np.float32), CAMERA, np.eye(4), truth=np.full((8, 8), 1.5, np.float32))
    h5.write(tmp_path / "in.h5", "views", artefact.views_arrays([clean], unit="m", measured="depth"), {})
    import_views.run(tmp_path / "in.h5", tmp_path / "out.h5", ImportViews(outliers=0.5), Run())
    np.testing.assert_array_equal(layouts.open_views(tmp_path / "out.h5").load("a").truth, clean.truth)


@pytest.mark.parametrize(
    ("params", "names"),
    [
        (ImportViews(reference="c", window=3), "bcd"),
        (ImportViews(reference="a", window=3), "abc"),
        (ImportViews(views="e, b"), "be"),
        (ImportViews(views="c,c"), "c"),
        (ImportViews(), "abcde"),
    ],
)
def test_views_are_select_names_in_the_order_of_the_sequence(params, names):
    assert select_names(NAMES, params) == tuple(names)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        (ImportViews(reference="c"), "belong together"),
        (ImportViews(window=3), "belong together"),
        (ImportViews(views="a", reference="c", window=3), "exclude each other"),
        (ImportViews(views="a,x"), "no view 'x' among the 5"),
    ],
)
def test_choices_that_make_no_sense_are_refused(params, message):
    with pytest.raises(ParameterError, match=message):
        select_names(NAMES, params)


def test_the_provenance_names_the_files_that_were_used_and_no_place(tmp_path):
    run(tmp_path, ImportViews(views="b"))
    record = h5.peek(tmp_path / "out.views.h5").provenance
    assert record["command"] == "import-views"
    assert [item["name"] for item in record["inputs"]] == ["in.h5"]
    assert str(tmp_path) not in str(record)


def test_a_changed_choice_does_not_replace_the_result(tmp_path):
    run(tmp_path, ImportViews())
    assert run(tmp_path, ImportViews())[0] is Outcome.UP_TO_DATE
    with pytest.raises(OutputExists, match="--overwrite"):
        run(tmp_path, replace(ImportViews(), views="a"))
