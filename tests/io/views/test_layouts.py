"""Layouts of views are told apart, and what fits none is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import h5
from ipcli.io.views import artefact, layouts


@pytest.fixture
def stored(tmp_path, views):
    path = tmp_path / "x.views.h5"
    h5.write(path, "views", artefact.views_arrays(views, unit="m", measured="depth"), {})
    return path


def test_an_artefact_is_known_by_its_suffix(stored):
    assert layouts.open_views(stored).names == ("0", "1", "2")


MARKS = {
    "colmap": ("sparse/cameras.bin", "stereo/depth_maps/a.png.geometric.bin", "depth/a.png", "poses.txt"),
    "tum": ("depth.txt", "groundtruth.txt", "depth/1.png"),
    "7scenes": ("frame-000000.depth.png", "frame-000000.pose.txt"),
    "scannet": ("depth/1.png", "pose/1.txt", "intrinsic/intrinsic_depth.txt"),
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


def test_the_nearest_layout_is_named_with_what_it_lacks(tmp_path):
    for part in ("depth", "pose"):
        (tmp_path / part).mkdir()
    with pytest.raises(FormatError, match=r"most like a ScanNet scene, but lacks intrinsic/intrinsic_depth\.txt"):
        layouts.open_views(tmp_path)


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
    layouts.open_views(stored, depth_scale=None)
    with pytest.raises(
        ParameterError, match="'depth_scale' means nothing to an HDF5 views artefact; that takes no hints"
    ):
        layouts.open_views(stored, depth_scale=1000.0)
    with pytest.raises(ParameterError, match=r"unknown format 'colmpa'; did you mean 'colmap'\?"):
        layouts.open_views(stored, "colmpa")
