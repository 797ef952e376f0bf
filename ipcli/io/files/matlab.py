"""MATLAB files by scipy, in a child process: its parser may crash on a damaged one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import check_file
from ipcli.io.files.guarded import ParserFailed, guarded

HDF5_BASED = b"MATLAB 7.3 MAT-file"  # how such files begin, which may link to other files; scipy does not read them


def read(path: Path, *, fix: str = "Check the copy") -> dict[str, np.ndarray]:
    """The variables of a file by name. Raises FormatError with `fix`."""
    if not path.is_file():  # scipy does not tell it from a damaged one
        raise FormatError(path, "no such file", fix="Add it to the folder")
    with check_file(path).open("rb") as stream:
        if stream.read(len(HDF5_BASED)) == HDF5_BASED:
            way_out = "In MATLAB, save it by save('NAME.mat', '-v7')"
            raise FormatError(path, "saved as MATLAB v7.3", expected="v5 to v7", fix=way_out)
    try:
        return guarded(content, str(path))
    except ParserFailed as error:
        raise FormatError(path, f"not a readable MATLAB file: {error}", fix=fix) from None


def content(path: str) -> dict[str, np.ndarray]:
    """The variables, in the child. Raises whatever the parser stumbles over."""
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
