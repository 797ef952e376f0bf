"""Where the commands of depth fusion take their views from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.stages.fusion.parameters import ViewSource
from ipcli.stages.fusion.sources import middle, open_scene, open_source, source_files
from tests.fixtures.errors import check_message
from tests.fixtures.fusion_scenes import scene, write

SHAPE = (6, 8)


@pytest.mark.parametrize(("count", "expected"), [(1, 0), (2, 0), (3, 1), (4, 1), (5, 2)])
def test_the_middle_has_as_many_views_before_as_after_or_one_less(count, expected):
    assert middle(tuple(map(str, range(count)))) == str(expected)


def test_a_scene_is_all_views_about_the_one_whose_truth_is_known(tmp_path):
    views = scene(4, SHAPE)
    path = write(tmp_path / "a.h5", views, measured="disparity", baseline_focal=40.0)
    found = open_scene(path, None, "auto")
    assert [view.name for view in found.views] == ["00", "01", "02", "03"]
    assert found.reference.name == "01"
    np.testing.assert_array_equal(found.truth, views[1].truth)
    assert (found.inverse, found.baseline_focal, found.unit) == (True, 40.0, "m")
    assert open_scene(path, "03", "depth").reference.name == "03"


@pytest.mark.parametrize(
    ("domain", "measured", "inverse"),
    [
        ("auto", "depth", False),
        ("auto", "disparity", True),
        ("depth", "disparity", False),
        ("disparity", "depth", True),
    ],
)
def test_the_domain_is_what_was_measured_unless_it_is_said(tmp_path, domain, measured, inverse):
    path = write(tmp_path / "a.h5", scene(1, SHAPE), measured=measured)
    assert open_scene(path, None, domain).inverse is inverse


def test_a_view_that_is_not_there_or_has_no_truth_is_refused(tmp_path):
    views = scene(3, SHAPE)
    path = write(tmp_path / "a.h5", [*views[:2], replace(views[2], truth=None)])
    with pytest.raises(ParameterError, match="a.h5: no view '1'; did you mean '01'"):
        open_scene(path, "1", "auto")
    with pytest.raises(FormatError) as raised:
        open_scene(path, "02", "auto")
    check_message(raised.value, "a.h5: the true depth of view '02' is not known")


def test_files_come_once_in_the_order_of_the_views(tmp_path):
    views = open_source(write(tmp_path / "a.h5", scene(2, SHAPE)), ViewSource())
    assert source_files(views, views.names) == (tmp_path / "a.h5",)
    shared = tmp_path / "poses.txt"
    split = replace(views, files=lambda name: (tmp_path / f"{name}.png", shared))
    assert source_files(split, ("01", "00")) == (tmp_path / "01.png", shared, tmp_path / "00.png")


def test_hints_reach_the_layout(tmp_path):
    path = write(tmp_path / "a.h5", scene(1, SHAPE))
    with pytest.raises(ParameterError, match="'unit' means nothing to an HDF5 views artefact"):
        open_source(path, replace(ViewSource(), unit="mm"))
