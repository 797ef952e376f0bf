"""One camera for an image whose view has no name, from the whole labelled model (in place of thesis 6.10 to 6.15).

The two-point energy (6.10) does not fix a view: it has four unknowns and three equations. Nor does the outline of one
inflated part. The overlap of all labels at once does: every direction is tried on a coarse grid of cells, the best are
refined. For a direction the scale and the shift follow from the silhouettes (see `cameras`), and how badly they and the
outlines of the parts (see `frontiers`) fit counts against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.geometry.orthographic import Orthographic, fibonacci
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.cameras import Outlines, outline_of
from ipcli.models.animal.frontiers import Frontiers, PartOutlines

DIRECTIONS, ROLLS = 400, 18  # tried, each with each
COARSE, FINE = 26, 72  # cells along the longer side of the image
SPARSE, DENSE = 1500, 8000  # points of the model on the two grids
KEPT, POLISHED = 24, 4  # candidates that are looked at on the fine grid, and that are refined
FRONTIER = 4.0  # overlap lost for a frontier error as large as the animal
PART_FRONTIER = 10.0  # the same, for that of the single parts
EVALUATIONS = 160  # of the objective in one refinement
TURN = np.radians(6.0)  # first step of a refinement


@dataclass(frozen=True, eq=False)
class LabelledPoints:
    """Points (n, 3) on a model's surface and the part + 1 (n,) of each."""

    points: np.ndarray
    labels: np.ndarray

    def thinned(self, count: int) -> LabelledPoints:
        """About so many of them, evenly by their order."""
        step = max(len(self.points) // count, 1)
        return LabelledPoints(self.points[::step], self.labels[::step])


def find_camera(
    image: PartImage, cloud: LabelledPoints, seen: Sequence[PartImage], cameras: Sequence[Orthographic]
) -> tuple[Orthographic, float]:
    """The camera of an image that sees the cloud as the image shows it, and how well it does: their overlap in [0, 1],
    less what the outlines disagree with those of the images `seen`, whose cameras are known.
    """
    known = Outlines.of([other.silhouette for other in seen], cameras), Frontiers.of(seen, cameras)
    coarse = Match.of(image, cloud.thinned(SPARSE), *known, COARSE)
    fine = Match.of(image, cloud.thinned(DENSE), *known, FINE)
    rotations = _rotations()
    scores = np.concatenate([coarse.scores(rolls) for rolls in rotations])
    rotations = rotations.reshape(-1, 3, 3)
    best = np.argsort(-scores)[:KEPT]
    again = np.array([fine.score(rotations[k]) for k in best])
    refined = [fine.refined(rotations[k]) for k in _apart(best[np.argsort(-again)], rotations)]
    rotation, score = max(refined, key=lambda item: item[1])
    return fine.camera(rotation), score


def _rotations() -> np.ndarray:
    """Rotations (DIRECTIONS, ROLLS, 3, 3): each direction with each roll."""
    turns = 2 * np.pi * np.arange(ROLLS) / ROLLS
    forward = fibonacci(DIRECTIONS)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right = (right / np.linalg.norm(right, axis=1, keepdims=True))[:, None]
    down = np.cross(forward[:, None], right)
    c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
    return np.stack([c * right + s * down, c * down - s * right, np.repeat(forward[:, None], ROLLS, axis=1)], axis=2)


def _apart(order: np.ndarray, rotations: np.ndarray) -> list[int]:
    """The first POLISHED of an order that are not close to one before."""
    chosen: list[int] = []
    for k in order:
        if all(np.trace(rotations[k] @ rotations[c].T) < 1 + 2 * np.cos(np.radians(25)) for c in chosen):
            chosen.append(int(k))
        if len(chosen) == POLISHED:
            break
    return chosen


@dataclass(frozen=True, eq=False)
class Match:
    """An image, a model and outlines of known cameras: how well does a rotation of the camera explain the image?"""

    cells: LabelCells
    outline: np.ndarray  # (n, 2) of the silhouette
    cloud: LabelledPoints
    corners: np.ndarray  # (k, 3) of the cloud's convex hull
    known: Outlines
    parts: PartOutlines
    frontiers: Frontiers

    @classmethod
    def of(cls, image: PartImage, cloud: LabelledPoints, known: Outlines, frontiers: Frontiers, count: int) -> Match:
        """With so many cells along the longer side of the image."""
        from scipy.spatial import ConvexHull

        corners = cloud.points[ConvexHull(cloud.points).vertices]
        cells, outline = LabelCells.of(image, count), outline_of(image.silhouette)
        return cls(cells, outline, cloud, corners, known, PartOutlines.of(image), frontiers)

    def scores(self, rotations: np.ndarray) -> np.ndarray:
        """Overlap less what the frontier points disagree, (n,) of rotations (n, 3, 3) that share one direction."""
        scales, shifts, errors = self.known.fit(self.outline, rotations, self.corners)
        lost = FRONTIER * errors / self.known.size
        lost += PART_FRONTIER * self.frontiers.error(self.parts, rotations, scales, shifts)
        return self.cells.overlaps(rotations, scales, shifts, self.cloud) - lost

    def score(self, rotation: np.ndarray) -> float:
        """That of one."""
        return float(self.scores(rotation[None])[0])

    def camera(self, rotation: np.ndarray) -> Orthographic:
        """The camera with this rotation."""
        (scale,), (shift,), _ = self.known.fit(self.outline, rotation[None], self.corners)
        return Orthographic(rotation, float(scale), shift)

    def refined(self, rotation: np.ndarray) -> tuple[np.ndarray, float]:
        """The best rotation near this one and its score, by the method of Nelder and Mead."""
        from scipy.optimize import minimize
        from scipy.spatial.transform import Rotation

        def turned(vector: Any) -> np.ndarray:
            return Rotation.from_rotvec(vector).as_matrix() @ rotation

        simplex = np.concatenate([np.zeros((1, 3)), TURN * np.eye(3)])
        options: Any = {"initial_simplex": simplex, "maxfev": EVALUATIONS, "xatol": 2e-3, "fatol": 1e-5}
        found: Any = minimize(
            lambda vector: -self.score(turned(vector)), np.zeros(3), method="Nelder-Mead", options=options
        )
        return turned(found.x), -float(found.fun)


@dataclass(frozen=True, eq=False)
class LabelCells:
    """An image's labels on a coarse grid of cells, to be compared with points that are splatted on it."""

    labels: np.ndarray  # (rows, columns)
    pixels: float  # side of a cell

    @classmethod
    def of(cls, image: PartImage, count: int) -> LabelCells:
        """So many cells along the longer side."""
        pixels = max(image.labels.shape) / count
        rows, columns = (np.arange(int(np.ceil(n / pixels))) for n in image.labels.shape)
        at = [
            np.minimum(((k + 0.5) * pixels).astype(int), n - 1)
            for k, n in zip((rows, columns), image.labels.shape, strict=True)
        ]
        return cls(image.labels[at[0][:, None], at[1]], pixels)

    def overlaps(
        self, rotations: np.ndarray, scales: np.ndarray, shifts: np.ndarray, cloud: LabelledPoints
    ) -> np.ndarray:
        """Cells whose label is that of the nearest point, over cells in which either shows something: (n,) of cameras
        with rotations (n, 3, 3), scales (n,) and shifts (n, 2) that look along one direction.
        """
        farthest_first = np.argsort(-(cloud.points @ rotations[0, 2]))
        plane = cloud.points[farthest_first] @ rotations[:, :2].transpose(0, 2, 1)  # (n, points, 2)
        at = np.floor((scales[:, None, None] * plane + (shifts[:, None] + 0.5)) / self.pixels).astype(np.int32)
        inside = ((at >= 0) & (at < self.labels.shape[::-1])).all(axis=-1)
        flat = np.arange(len(rotations))[:, None] * self.labels.size + at[..., 1] * self.labels.shape[1] + at[..., 0]
        drawn = np.zeros((len(rotations), self.labels.size), cloud.labels.dtype)
        drawn.ravel()[flat[inside]] = np.broadcast_to(cloud.labels[farthest_first], inside.shape)[inside]
        either = (drawn > 0) | (self.labels.ravel() > 0)
        count, same = either.sum(axis=1), ((drawn == self.labels.ravel()) & either).sum(axis=1)
        return same / (count * (2 - inside.mean(axis=1)))


def cloud_of(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray) -> LabelledPoints:
    """The middles of a mesh's faces."""
    return LabelledPoints(vertices[faces].mean(axis=1).astype(np.float64), (face_part + 1).astype(np.int16))
