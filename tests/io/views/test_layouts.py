from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import h5
from ipcli.io.views import artefact, layouts


@pytest.fixture
def stored(tmp_path, views):
    """Three views of two sizes; the first with confidence and truth, the last without image."""
    small = replace(views[2], depth=views[2].depth[:7, :9], image=None)
    full = replace(views[0], confidence=np.ones_like(views[0].depth), truth=views[0].depth)
    path = tmp_path / "x.views.h5"
    arrays = artefact.views_arrays([small, full, views[1]], unit="m", measured="disparity", baseline_focal=40.0)
    h5.write(path, "views", arrays, {})
    return path, (full, views[1], small)


def test_an_artefact_gives_back_the_views_that_went_into_it(stored):
    path, written = stored
    sequence = layouts.open_views(path)
    assert (sequence.names, sequence.unit, sequence.measured, sequence.baseline_focal) == (
        ("0", "1", "2"),
        "m",
        "disparity",
        40.0,
    )
    assert sequence.files("1") == (path,)
    for name, view in zip(sequence.names, written, strict=True):
        found = sequence.load(name)
        for field in artefact.PER_VIEW:
            np.testing.assert_equal(getattr(found, field), getattr(view, field))


def test_an_artefact_with_a_pose_that_is_not_rigid_is_refused(tmp_path, views):
    bad = replace(views[1], cam_from_world=np.diag([2.0, 1.0, 1.0, 1.0]))
    h5.write(tmp_path / "x.h5", "views", artefact.views_arrays([bad], unit="m", measured="depth"), {})
    sequence = layouts.open_views(tmp_path / "x.h5")
    assert sequence.baseline_focal is None
    with pytest.raises(FormatError, match="x.h5: view '1': pose is not rigid"):
        sequence.load("1")


MARKS = {
    "colmap": ("sparse/cameras.bin", "stereo/depth_maps/a.png.geometric.bin", "depth/a.png", "poses.txt"),
    "tum": ("depth.txt", "groundtruth.txt", "depth/1.png"),
    "7scenes": ("frame-000000.depth.png", "frame-000000.pose.txt"),
    "open3d": ("depth/1.png", "trajectory.log"),
    "folder": ("depth/a.png", "poses.txt", "intrinsics.txt"),
}


@pytest.mark.parametrize("format", MARKS)
def test_layouts_are_told_apart(tmp_path, monkeypatch, format):
    for name in MARKS[format]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for key, layout in layouts.LAYOUTS.items():
        monkeypatch.setitem(layouts.LAYOUTS, key, replace(layout, open=lambda path, key=key: key))
    assert layouts.open_views(tmp_path) == format


def test_what_no_layout_fits_is_refused_with_what_was_looked_for(tmp_path):
    with pytest.raises(
        FormatError,
        match=r"no known layout of views\. Looked for .*depth\.txt and groundtruth\.txt.*depth/ and poses\.txt",
    ):
        layouts.open_views(tmp_path)
    with pytest.raises(FormatError, match="nowhere: no such file or folder"):
        layouts.open_views(tmp_path / "nowhere")
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(FormatError, match=r"notes\.txt"):
        layouts.open_views(tmp_path / "notes.txt")


def test_hints_that_a_layout_has_no_use_for_and_formats_unknown_are_refused(stored):
    path, _ = stored
    layouts.open_views(path, depth_scale=None)
    with pytest.raises(
        ParameterError, match="'depth_scale' means nothing to an HDF5 views artefact; that takes no hints"
    ):
        layouts.open_views(path, depth_scale=1000.0)
    with pytest.raises(ParameterError, match=r"unknown format 'colmpa'; did you mean 'colmap'\?"):
        layouts.open_views(path, "colmpa")
