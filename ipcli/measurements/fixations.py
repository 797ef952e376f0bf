"""Where people looked: pictures with fixations, and surfaces whose vertices say how long they were looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class FixatedPicture:
    """A picture, read when asked for, and its fixations: points (n, 2) as x, y in pixels from the left top corner.

    `observers` (n,) int64 says whose each is.
    """

    name: str
    read: Callable[[], np.ndarray]  # (h, w, 3) uint8 RGB
    fixations: np.ndarray
    observers: np.ndarray


@dataclass(frozen=True, eq=False)
class FixatedSurface:
    """Vertices (n, 3) with normals (n, 3) and triangles if there are, how long each vertex was looked at (n,) in
    seconds, and which (n,) bool count as looked at.
    """

    name: str
    vertices: np.ndarray
    normals: np.ndarray
    attention: np.ndarray
    looked_at: np.ndarray
    faces: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class FixationSet:
    """Pictures or surfaces with fixations; one of the two is empty."""

    pictures: tuple[FixatedPicture, ...] = ()
    surfaces: tuple[FixatedSurface, ...] = ()
    notes: tuple[str, ...] = ()  # what the reader left out

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its items, in order."""
        return (*(item.name for item in self.pictures), *(item.name for item in self.surfaces))
