"""Where tests marked `real` find their data, and how hypothesis runs."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).parents[1]

settings.register_profile("ipcli", deadline=None)  # the first call of a kernel compiles it
settings.load_profile("ipcli")


@pytest.fixture(scope="session")
def real_data() -> Callable[[str], Path]:
    """A folder of real data by its name below $IPCLI_DATA (default: ../shared/data), or a skipped test."""
    place = Path(os.environ.get("IPCLI_DATA", ROOT.parent / "shared" / "data"))

    def find(name: str) -> Path:
        if not (place / name).is_dir():
            pytest.skip(f"no {name} below {place}; set IPCLI_DATA")
        return place / name

    return find


@pytest.fixture(autouse=True)
def logging_as_it_was() -> None:
    """A command sets up the logger of ipcli for its process: no later test sees that, nor that of a shared fixture."""
    logger = logging.getLogger("ipcli")
    logger.handlers, logger.propagate = [], True
    logger.setLevel(logging.NOTSET)
