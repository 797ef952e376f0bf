"""The page of an artefact as a file beside it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipcli import report
from ipcli.io.files import atomic
from ipcli.report.kit.page import with_turning_page

if TYPE_CHECKING:
    import numpy as np

    from ipcli.stages.kit.artefact import Beside


def page(output: Path, kind: str) -> dict[Path, Beside]:
    """The side file X.html of an artefact X.h5 of this kind, with its writer."""
    return {output.with_suffix(".html"): partial(_write, kind, turning_page(output).name)}


def turning_page(output: Path) -> Path:
    """The side file of an artefact in which its surface can be turned."""
    return output.with_suffix(".turn.html")


def _write(kind: str, turned: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    atomic.write_text(path, with_turning_page(report.renderer(kind)(arrays, provenance), turned))
