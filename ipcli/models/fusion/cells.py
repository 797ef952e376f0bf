"""Points of many maps, averaged within the cells of a grid while they come in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.cameras import transform

CELLS = 1 << 20  # along an axis, so that three indices fit into one integer
WAITING = 2_000_000  # points that wait at most before they are averaged, or as many as there are cells by then


@dataclass(frozen=True, eq=False)
class Points:
    """Points in the frame of one camera or of the world; arrays of one length."""

    position: np.ndarray  # (n, 3) float64
    normal: np.ndarray  # (n, 3) float64
    color: np.ndarray | None  # (n, 3)
    precision: np.ndarray  # (n,) float64
    confidence: np.ndarray  # (n,) float64
    views: np.ndarray  # (n,) number of maps that agree

    def moved(self, motion: np.ndarray) -> Points:
        """By a rigid motion (4, 4)."""
        return replace(self, position=transform(motion, self.position), normal=self.normal @ motion[:3, :3].T)

    def each(self, function: Callable[[np.ndarray], np.ndarray]) -> Points:
        """The function of every array."""
        arrays = {name: getattr(self, name) for name in Points.__dataclass_fields__}
        return Points(**{name: None if array is None else function(array) for name, array in arrays.items()})


class Cells:
    """One point a cell: means weighted by precision of position, normal, colour and confidence; the most of the views.

    Each point holds the confidences of all maps that agree on it already, so that they are not summed once more here.
    """

    def __init__(self, spacing: float):
        self._spacing = spacing
        self._parts: list[tuple[np.ndarray, Points]] = []  # (cell of each point, points); the first one is averaged
        self._averaged = self._waiting = 0

    def add(self, points: Points) -> None:
        """Take these points too. ParameterError for a spacing too fine for the extent."""
        cells = np.floor(points.position / self._spacing) + CELLS // 2
        if len(cells) and not 0 <= cells.min() <= cells.max() < CELLS:
            raise ParameterError(
                f"merge.spacing: {self._spacing:g} divides the cloud into more than {CELLS} cells along an axis; give "
                "more"
            )
        self._parts.append((cells.astype(np.int64) @ np.array([CELLS * CELLS, CELLS, 1]), points))
        self._waiting += len(cells)
        if self._waiting > max(WAITING, self._averaged):
            self._average()

    def points(self) -> Points:
        """One a cell, in the order of the cells."""
        self._average()
        points = self._parts[0][1]
        length = np.linalg.norm(points.normal, axis=1, keepdims=True)
        color = None if points.color is None else np.rint(points.color).astype(np.uint8)
        return replace(points, normal=points.normal / np.maximum(length, np.finfo(float).tiny), color=color)

    def _average(self) -> None:
        key, points = np.concatenate([key for key, _ in self._parts]), joined([points for _, points in self._parts])
        order = np.argsort(key, kind="stable")
        starts = np.flatnonzero(np.diff(key[order], prepend=-1))
        weight = points.precision[order]
        total = np.add.reduceat(weight, starts) if len(starts) else weight

        def mean(values: np.ndarray) -> np.ndarray:
            weighted = (values[order].T * weight).T
            return (np.add.reduceat(weighted, starts, axis=0).T / total).T if len(starts) else weighted

        averaged = replace(points, views=None, precision=None).each(mean)
        views = np.maximum.reduceat(points.views[order], starts) if len(starts) else points.views
        self._parts = [(key[order][starts], replace(averaged, precision=total, views=views))]
        self._averaged, self._waiting = len(total), 0


def joined(parts: list[Points]) -> Points:
    """All points; colours only if all have them."""
    if any(part.color is None for part in parts):
        parts = [replace(part, color=None) for part in parts]
    names = [name for name in Points.__dataclass_fields__ if getattr(parts[0], name) is not None]
    return Points(
        **({"color": None} | {name: np.concatenate([getattr(part, name) for part in parts]) for name in names})
    )
