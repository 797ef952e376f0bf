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
