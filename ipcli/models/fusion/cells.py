"""Points of many maps, averaged within the cells of a grid while they come in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.cameras import transform

CELLS = 1 << 20  # along an axis, so that three indices fit into one integer
WAITING = 2_000_000  # points that wait at most before they are averaged, or as many as there are cells by then


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points in the frame of one camera or of the world; arrays of one length."""

    position: np.ndarray  # (n, 3) float64
    normal: np.ndarray  # (n, 3) float64
    color: np.ndarray | None  # (n, 3)
    precision: np.ndarray  # (n,) float64
    confidence: np.ndarray  # (n,) float64
    views: np.ndarray  # (n,) number of maps that agree

    def transform(self, motion: np.ndarray) -> SurfacePoints:
        """The points moved by a rigid motion (4, 4)."""
        return replace(self, position=transform(motion, self.position), normal=self.normal @ motion[:3, :3].T)


class Cells:
    """A grid with one point a cell: means of position, normal, colour and confidence, weighted by precision, and the
    largest number of views.

    Each point holds the confidences of all maps that agree on it already, so that they are not summed once more here.
    """

    def __init__(self, spacing: float, most: int | None = None):
        self._spacing, self._most = spacing, most
        self._parts: list[
            tuple[np.ndarray, SurfacePoints]
        ] = []  # (cell of each point, points); the first one is averaged
        self._averaged = self._waiting = 0

    def add(self, points: SurfacePoints) -> None:
        """Average these points in. ParameterError for a spacing too fine for the extent or for `most` points."""
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

    def points(self) -> SurfacePoints:
        """One averaged point a cell, in the order of the cells."""
        self._average()
        points = self._parts[0][1]
        length = np.linalg.norm(points.normal, axis=1, keepdims=True)
        color = None if points.color is None else np.rint(points.color).astype(np.uint8)
        return replace(points, normal=points.normal / np.maximum(length, np.finfo(float).tiny), color=color)

    def _average(self) -> None:
        key, points = (
            np.concatenate([key for key, _ in self._parts]),
            concatenate([points for _, points in self._parts]),
        )
        order = np.argsort(key, kind="stable")
        starts = np.flatnonzero(np.diff(key[order], prepend=-1))
        weight = points.precision[order]
        total = np.add.reduceat(weight, starts) if len(starts) else weight

        def mean(values: np.ndarray) -> np.ndarray:
            weighted = (values[order].T * weight).T
            return (np.add.reduceat(weighted, starts, axis=0).T / total).T if len(starts) else weighted

        averaged = SurfacePoints(
            mean(points.position),
            mean(points.normal),
            None if points.color is None else mean(points.color),
            total,
            mean(points.confidence),
            np.maximum.reduceat(points.views[order], starts) if len(starts) else points.views,
        )
        self._parts = [(key[order][starts], averaged)]
        self._averaged, self._waiting = len(total), 0
        if self._most is not None and self._averaged > self._most:
            raise ParameterError(
                f"merge.spacing: {self._spacing:g} makes a cloud of more than {self._most} points, which does not fit "
                "into --max-memory: give more, or raise that"
            )


def concatenate(parts: list[SurfacePoints]) -> SurfacePoints:
    """The points of all parts in order; colours only if all have them."""
    colors = [part.color for part in parts if part.color is not None]
    return SurfacePoints(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.normal for part in parts]),
        np.concatenate(colors) if len(colors) == len(parts) else None,
        np.concatenate([part.precision for part in parts]),
        np.concatenate([part.confidence for part in parts]),
        np.concatenate([part.views for part in parts]),
    )
