"""Scratch files give back what was put there, by rectangles, and leave nothing behind."""

import errno
import io
import os

import numpy as np
import pytest

from ipcli.io.files import scratch


def test_a_rectangle_is_that_of_the_array_and_nothing_is_left_in_the_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(scratch, "STRIP", 100)  # several strips
    array = np.random.default_rng(0).normal(size=(23, 17)).astype(np.float32)
    with scratch.ScratchFiles(tmp_path / "new") as files:
        files.put("a", array)
        files.put("a", np.zeros((1, 1)))  # the first stays
        np.testing.assert_array_equal(files.get("a"), array)
        found = files.get("a", slice(5, 90), slice(3, 11))
        np.testing.assert_array_equal(found, array[5:90, 3:11])
        assert found.flags.writeable
        assert files.get("a", slice(30, 40), slice(0, 5)).shape == (0, 5)
        assert "a" in files
        assert "b" not in files
        assert not list((tmp_path / "new").iterdir())
    with pytest.raises(KeyError):
        files.get("a")


def test_a_full_disk_is_told_with_its_folder(tmp_path, monkeypatch):
    class Full(io.BytesIO):
        def write(self, data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(scratch.tempfile, "TemporaryFile", lambda dir: Full())
    with (
        scratch.ScratchFiles(tmp_path) as files,
        pytest.raises(OSError, match=r"No space left on device: '.*test_a_full_disk"),
    ):
        files.put("a", np.zeros((2, 2)))
