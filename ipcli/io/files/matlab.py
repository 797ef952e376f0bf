"""MATLAB files by scipy, in a child process: its parser may crash on a damaged one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files.guarded import ParserFailed, guarded


def read(path: Path, *, fix: str = "Check the copy") -> dict[str, np.ndarray]:
    """The variables of a file by name. Raises FormatError with `fix`."""
    if not path.is_file():  # scipy does not tell it from a damaged one
        raise FormatError(path, "no such file", fix="Add it to the folder")
    try:
        return guarded(content, str(path))
    except ParserFailed as error:
        raise FormatError(path, f"not a readable MATLAB file: {error}", fix=fix) from None


def content(path: str) -> dict[str, np.ndarray]:
    """The variables, in the child. Raises whatever the parser stumbles over."""
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
