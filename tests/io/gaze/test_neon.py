"""Neon's own files, written here: parts in order, blinks and glasses that are not worn."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.gaze.gaze_files import read_gaze
from ipcli.io.gaze.neon import BLINK


@pytest.fixture
def folder(tmp_path):
    start = 1_700_000_000_000_000_000
    for part, first in (("ps1", 0), ("ps2", 4), ("ps10", 8)):
        numbers = np.arange(first, first + 4)
        np.stack([100.0 + numbers, 50.0 - numbers], axis=1).astype("<f4").tofile(tmp_path / f"gaze {part}.raw")
        (start + numbers * 5_000_000).astype("<i8").tofile(tmp_path / f"gaze {part}.time")
        np.where(numbers == 5, 0, 255).astype("u1").tofile(tmp_path / f"worn {part}.raw")
    blink = np.array([(1, start + 9_000_000, start + 16_000_000)], BLINK)
    blink.tofile(tmp_path / "blinks ps1.raw")
    return tmp_path


def test_samples_of_all_parts_with_blinks_and_unworn_left_out(folder):
    gaze = read_gaze(folder)
    assert gaze.source == "Pupil Neon"
    np.testing.assert_allclose(gaze.pixels[:, 0], 100 + np.arange(12))
    np.testing.assert_allclose(np.diff(gaze.times), 0.005, atol=1e-6)
    assert np.flatnonzero(~gaze.valid).tolist() == [2, 3, 5]


def test_cut_files_and_unequal_numbers_are_refused(folder):
    path = folder / "gaze ps2.time"
    whole = path.read_bytes()
    path.write_bytes(whole[:-3])
    with pytest.raises(FormatError, match="cut or too long"):
        read_gaze(folder)
    path.write_bytes(whole[:-8])
    with pytest.raises(FormatError, match="differ in number"):
        read_gaze(folder)
    path.unlink()
    with pytest.raises(FormatError, match="cannot be read"):
        read_gaze(folder)
