"""The view of one part from its outline alone: all directions are tried, the best few refined.

An outline is compared apart from a similarity of the image: first by its radial signature, whose turn within the image
a correlation finds, then by the overlap of both silhouettes. A part that is its own mirror image has two views with
one outline, so several are given.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ipcli.geometry.orthographic import fibonacci

DIRECTIONS = 800  # tried, about 7 degrees apart
BINS = 72  # of a radial signature
CELLS = 48  # along each side of the picture in which silhouettes overlap
WIDEST = 2.6  # half side of that picture, in roots of the silhouette's area
LOOKED_AT, REFINED = 48, 8  # different candidates that are laid over the outline, and that are refined
APART = np.cos(np.radians(20.0))  # of two candidates: closer ones count as one
TURN = np.radians(6.0)  # first step of a refinement
EVALUATIONS = 80  # of the overlap in one


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A silhouette apart from where it lies and how large it is: its middle (2,), the root of its area, the middles
    (n, 2) of cells that it covers, about its own and in roots of the area, and the side of these.
    """

    middle: np.ndarray
    extent: float
    cells: np.ndarray
    side: float

    @classmethod
    def of(cls, points: np.ndarray, side: float) -> Silhouette:
        """That of points (n, 2) dense enough to hit every cell of this side, but for holes."""
        from scipy.ndimage import binary_fill_holes

        low = points.min(axis=0) - side
        at = ((points - low) / side).astype(np.int32)
        mask = np.zeros(at.max(axis=0) + 2, bool)
        mask[at[:, 0], at[:, 1]] = True
        cells = np.argwhere(binary_fill_holes(mask)) * side + low + side / 2
        middle, extent = cells.mean(axis=0), side * float(np.sqrt(len(cells)))
        return cls(middle, extent, (cells - middle) / extent, side / extent)

    @cached_property
    def signature(self) -> np.ndarray:
        """How far it reaches in each of BINS directions from its middle, in roots of the area."""
        turn = np.arctan2(self.cells[:, 1], self.cells[:, 0])
        reach = np.zeros(BINS)
        np.maximum.at(reach, (turn / (2 * np.pi) * BINS).astype(np.int32) % BINS, np.linalg.norm(self.cells, axis=1))
        return np.maximum(reach, np.maximum(np.roll(reach, 1), np.roll(reach, -1)))

    @cached_property
    def covered(self) -> np.ndarray:
        """Which cells of a picture (CELLS, CELLS) about its middle it covers."""
        number = int(np.ceil(2 * WIDEST / self.side)) + 1
        mask = np.zeros((number, number), bool)
        at = np.clip(np.rint((self.cells + WIDEST) / self.side).astype(int), 0, number - 1)
        mask[at[:, 0], at[:, 1]] = True
        middles = (np.arange(CELLS) + 0.5) / CELLS * 2 * WIDEST
        nearest = np.clip(np.rint(middles / self.side).astype(int), 0, number - 1)
        return mask[np.ix_(nearest, nearest)]

    def overlap(self, other: Silhouette) -> float:
        """Intersection over union of both, laid on each other by middle and area."""
        return float((self.covered & other.covered).sum() / max(int((self.covered | other.covered).sum()), 1))

    def turned(self, other: Silhouette) -> tuple[float, float]:
        """By how much (radians) to turn this signature to meet another's best, and the mean square that is left."""
        product = np.fft.ifft(np.conj(np.fft.fft(self.signature)) * np.fft.fft(other.signature)).real
        shift = int(np.argmax(product))
        left = (self.signature**2).sum() + (other.signature**2).sum() - 2 * product[shift]
        return 2 * np.pi * shift / BINS, float(left) / BINS


@dataclass(frozen=True, eq=False)
class PartOutline:
    """Points (n, 3) all over a part's surface, no two neighbours farther apart than `side`, and the silhouette that an
    image shows of the part.
    """

    points: np.ndarray
    side: float
    shown: Silhouette

    def seen(self, rotation: np.ndarray) -> Silhouette:
        """What a camera with this rotation sees."""
        return Silhouette.of(self.points @ rotation[:2].T, self.side)

    def overlap(self, rotation: np.ndarray) -> float:
        """How well a rotation explains the outline, in [0, 1]."""
        return self.seen(rotation).overlap(self.shown)

    def views(self, count: int) -> list[np.ndarray]:
        """Rotations (3, 3) of up to `count` views that look most like the image, best first."""
        tried = []
        for upright in _uprights():
            angle, left = self.seen(upright).turned(self.shown)
            tried.append((left, _rolled(upright, angle)))
        tried.sort(key=lambda item: item[0])
        return self.refined(np.array([rotation for _, rotation in tried]), count)

    def refined(self, rotations: np.ndarray, count: int) -> list[np.ndarray]:
        """The best up to `count` of rotations (n, 3, 3), best first, after a refinement.

        Of these, in their order, the first LOOKED_AT different ones are looked at, and the best REFINED refined.
        """
        looked = sorted(distinct(rotations, LOOKED_AT), key=self.overlap, reverse=True)
        better = sorted(map(self._refined, looked[:REFINED]), key=self.overlap, reverse=True)
        return distinct(np.array(better), count)

    def _refined(self, rotation: np.ndarray) -> np.ndarray:
        from scipy.optimize import minimize
        from scipy.spatial.transform import Rotation

        def turned(vector: Any) -> np.ndarray:
            return Rotation.from_rotvec(vector).as_matrix() @ rotation

        simplex = np.concatenate([np.zeros((1, 3)), TURN * np.eye(3)])
        options: Any = {"initial_simplex": simplex, "maxfev": EVALUATIONS, "xatol": 5e-3, "fatol": 1e-4}
        found = minimize(
            lambda vector: -self.overlap(turned(vector)), np.zeros(3), method="Nelder-Mead", options=options
        )
        return turned(found.x)


def distinct(rotations: np.ndarray, count: int) -> list[np.ndarray]:
    """The first up to `count` of rotations (n, 3, 3) that are not close to one before."""
    chosen: list[np.ndarray] = []
    while len(rotations) and len(chosen) < count:
        chosen.append(rotations[0])
        cosine = (np.einsum("nij,ij->n", rotations, rotations[0]) - 1) / 2
        rotations = rotations[cosine < APART]
    return chosen


def _uprights() -> np.ndarray:
    """A rotation (n, 3, 3) for each direction of view."""
    forward = fibonacci(DIRECTIONS)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return np.stack([right, np.cross(forward, right), forward], axis=1)


def _rolled(rotation: np.ndarray, angle: float) -> np.ndarray:
    """The camera turned so that what it sees is turned by an angle, from column to row."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ rotation
