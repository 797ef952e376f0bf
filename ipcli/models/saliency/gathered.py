"""Points of many subsequences as one cloud, whose size depends on the scene and not on how long it is looked at."""

from __future__ import annotations

import numpy as np

MOST = 120_000  # points that are kept
FINEST = 0.01  # metres


class GatheredCloud:
    """Points (n, 3) with values (n, c); those of a voxel become their mean, and voxels grow when there are too many."""

    def __init__(self, width: int, most: int = MOST):
        self.most, self.voxel = most, FINEST
        self.rows = np.empty((0, 3 + width))
        self.counts: np.ndarray = np.empty(0)

    def add(self, points: np.ndarray, values: np.ndarray) -> None:
        """Take these points in."""
        self.rows = np.concatenate([self.rows, np.concatenate([points, values], axis=1)])
        self.counts = np.concatenate([self.counts, np.ones(len(points))])
        self._merge()
        while len(self.rows) > self.most:
            self.voxel *= 1.5
            self._merge()

    def _merge(self) -> None:
        if not len(self.rows):
            return
        cells = np.floor(self.rows[:, :3] / self.voxel).astype(np.int64)
        _, index = np.unique(cells, axis=0, return_inverse=True)
        index = index.ravel()
        counts = np.bincount(index, weights=self.counts)
        columns = [np.bincount(index, weights=self.counts * column) / counts for column in self.rows.T]
        self.rows, self.counts = np.stack(columns, axis=1), counts
