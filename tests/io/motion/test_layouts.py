"""Layouts of motion are told apart by what lies in them."""

from __future__ import annotations

import tarfile
from dataclasses import replace

import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.motion import layouts, recordings
from tests.fixtures.errors import check_message
from tests.fixtures.mocap_clips import every, write

MARKS = {
    "clips": ("a.h5",),
    "florence3d": ("any/skeletal_data.mat", "any/action_names.mat", "other/a.bvh"),
    "utkinect": ("set/joints/joints_s01_e01.txt", "set/joints/actionLabel.txt"),
    "files": ("wave/a.bvh", "notes.txt"),
}


@pytest.fixture
def told(monkeypatch):
    """Which layout opens a source."""
    for key, layout in layouts.LAYOUTS.items():
        monkeypatch.setitem(layouts.LAYOUTS, key, replace(layout, open=lambda path, key=key: key))
    return layouts.open_clips


def lay(folder, format):
    for name in MARKS[format]:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    return folder / "a.h5" if format == "clips" else folder


def test_every_layout_is_tried_here():
    assert set(MARKS) == set(layouts.LAYOUTS)


@pytest.mark.parametrize("format", MARKS)
def test_layouts_are_told_apart(tmp_path, told, format):
    assert told(lay(tmp_path, format)) == format


@pytest.mark.parametrize("format", ["utkinect", "florence3d", "files"])
def test_and_so_are_their_archives(tmp_path, told, format):
    folder = lay(tmp_path / "in", format)
    with tarfile.open(tmp_path / "a.tar.xz", "w:xz") as tar:
        tar.add(folder, ".")
    assert told(tmp_path / "a.tar.xz") == format


@pytest.mark.parametrize("suffix", recordings.READERS)
def test_a_motion_file_alone_is_read(tmp_path, told, suffix):
    (tmp_path / f"a01_s01_e01{suffix}").touch()
    assert told(tmp_path / f"a01_s01_e01{suffix}") == "files"


def test_any_text_is_no_motion(tmp_path):
    (tmp_path / "readme.txt").touch()
    with pytest.raises(FormatError, match="no known layout"):
        layouts.open_clips(tmp_path)


def test_what_no_layout_fits_is_refused_with_all_that_are_known(tmp_path):
    with pytest.raises(FormatError) as raised:
        layouts.open_clips(tmp_path)
    check_message(raised.value, "no known layout of clips", "docs/motions.md", *MARKS, ".bvh", "skeletal_data.mat")


def test_an_artefact_takes_no_hints(tmp_path):
    path = write(tmp_path / "a.h5", every(frames=2, repeats=1))
    assert len(layouts.open_clips(path, unit=None).names) == 12
    with pytest.raises(ParameterError, match="'unit' means nothing to an HDF5 clips artefact; that takes no hints"):
        layouts.open_clips(path, unit="cm")
