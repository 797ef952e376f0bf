"""Surfaces that were looked at: labels, or the longest times, say where."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import npz
from ipcli.io.fixations.surfaces import open_surface_set
from tests.fixtures.fixation_sets import write_surfaces


def change(folder, **arrays):
    file = folder / "ball0.npz"
    npz.write(file, {name: part for name, part in (npz.read(file) | arrays).items() if part is not None})
    return folder


def test_labels_say_what_was_looked_at(tmp_path):
    found = open_surface_set(write_surfaces(tmp_path)).surfaces
    assert [one.name for one in found] == ["ball0", "ball1", "ball2"]
    assert np.array_equal(found[0].looked_at, found[0].attention > 0)
    assert np.linalg.norm(found[0].normals, axis=1) == pytest.approx(1)


def test_without_labels_the_longest_times_are_what_was_looked_at(tmp_path):
    times = np.arange(1500, dtype=np.float32)
    change(write_surfaces(tmp_path, 1), label=None, fix_time=times)
    (one,) = open_surface_set(tmp_path).surfaces
    assert one.looked_at.sum() == 75
    assert one.looked_at[-75:].all()


def test_normals_of_any_length_are_made_unit_and_missing_ones_point_up(tmp_path):
    normals = np.tile(np.float32([3, 4, 0]), (1500, 1))
    normals[5] = 0
    (one,) = open_surface_set(change(write_surfaces(tmp_path, 1), normal=normals)).surfaces
    assert one.normals[0] == pytest.approx([0.6, 0.8, 0])
    assert one.normals[5] == pytest.approx([0, 0, 1])


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"normal": None}, "no 'normal'"),
        ({"xyz": np.zeros((1500, 2))}, "wrong shape"),
        ({"fix_time": np.zeros(3)}, "do not agree"),
        ({"fix_time": np.full(1500, np.nan)}, "not finite"),
        ({"fix_time": np.full(1500, -1.0)}, "below 0"),
        ({"label": np.zeros(3)}, "label: wrong shape"),
        ({"label": np.zeros(1500)}, "no vertex was looked at"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, arrays, message):
    with pytest.raises(FormatError, match=message):
        open_surface_set(change(write_surfaces(tmp_path, 1), **arrays))
