"""MATLAB files come as what was saved; damaged and absent ones name the file."""

import numpy as np
import pytest
from scipy.io import savemat

from ipcli.errors import FormatError
from ipcli.io.files import matlab


def test_variables_are_what_was_saved(tmp_path):
    cells = np.empty((1, 2), object)
    cells[0, 0], cells[0, 1] = {"x": np.arange(3.0)}, {"x": np.zeros((0, 1))}
    savemat(tmp_path / "a.mat", {"table": np.eye(2), "cells": cells})
    found = matlab.read(tmp_path / "a.mat")
    assert set(found) == {"table", "cells"}
    np.testing.assert_array_equal(found["table"], np.eye(2))
    np.testing.assert_array_equal(found["cells"][0, 0]["x"][0, 0].ravel(), [0.0, 1.0, 2.0])


@pytest.mark.parametrize("data", [b"", b"nonsense", b"MATLAB 5.0 MAT-file" + bytes(200)])
def test_damaged_ones_are_refused_with_their_cure(tmp_path, data):
    (tmp_path / "a.mat").write_bytes(data)
    with pytest.raises(FormatError, match=r"a\.mat.*not a readable MATLAB file.*Copy it again"):
        matlab.read(tmp_path / "a.mat", fix="Copy it again")


def test_one_that_is_not_there_is_said_so(tmp_path):
    with pytest.raises(FormatError, match="no such file"):
        matlab.read(tmp_path / "a.mat")


def test_the_format_7_3_is_named_with_the_way_out(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        file["x"] = h5py.ExternalLink("/etc/hosts", "/x")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM"
    (tmp_path / "a.mat").write_bytes(head + (tmp_path / "a.mat").read_bytes()[len(head) :])
    with pytest.raises(FormatError, match=r"a\.mat: saved as MATLAB v7\.3.*save\('NAME\.mat', '-v7'\)"):
        matlab.read(tmp_path / "a.mat")
