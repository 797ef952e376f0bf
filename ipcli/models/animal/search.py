"""One camera for an image whose view has no name, from the whole labelled model (in place of thesis 6.10 to 6.15).

The two-point energy (6.10) does not fix a view: it has four unknowns and three equations. Nor does the outline of one
inflated part. The overlap of all labels at once does: every direction is tried on a coarse grid of cells, the best are
refined. For a direction the scale and the shift follow from the silhouettes (see `cameras`), and how badly they fit
counts against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.geometry.orthographic import Orthographic, fibonacci
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.cameras import Outlines, outline_of

DIRECTIONS, ROLLS = 400, 18  # tried, each with each
COARSE, FINE = 26, 72  # cells along the longer side of the image
KEPT, POLISHED = 24, 4  # candidates that are looked at on the fine grid, and that are refined
FRONTIER = 4.0  # overlap lost for a frontier error as large as the animal
EVALUATIONS = 160  # of the objective in one refinement
TURN = np.radians(6.0)  # first step of a refinement


@dataclass(frozen=True, eq=False)
class LabelledPoints:
    """Points (n, 3) on a model's surface and the part + 1 (n,) of each."""

    points: np.ndarray
    labels: np.ndarray


def find_camera(image: PartImage, cloud: LabelledPoints, known: Outlines) -> tuple[Orthographic, float]:
    """The camera of an image that sees the cloud as the image shows it, and their overlap in [0, 1]."""
    coarse, fine = LabelCells.of(image, COARSE), LabelCells.of(image, FINE)
    outline = outline_of(image.silhouette)
    few = LabelledPoints(cloud.points[::3], cloud.labels[::3])
    rotations = _rotations()
    scores = np.array([_score(rotation, outline, few, known, coarse) for rotation in rotations])
    best = np.argsort(-scores)[:KEPT]
    again = np.array([_score(rotations[k], outline, cloud, known, fine) for k in best])
    refined = [_refined(rotations[k], outline, cloud, known, fine) for k in _apart(best[np.argsort(-again)], rotations)]
    rotation, _ = max(refined, key=lambda item: item[1])
    camera, _ = known.fit(outline, rotation, cloud.points)
    return camera, fine.overlap(camera, cloud)


def _rotations() -> np.ndarray:
    """Rotations (n, 3, 3): each direction with each roll."""
    turns = 2 * np.pi * np.arange(ROLLS) / ROLLS
    found = []
    for direction in fibonacci(DIRECTIONS):
        right = np.cross(direction, [0.0, 0.0, 1.0])
        right = right / np.linalg.norm(right)
        down = np.cross(direction, right)
        found += [
            [np.cos(t) * right + np.sin(t) * down, np.cos(t) * down - np.sin(t) * right, direction] for t in turns
        ]
    return np.array(found)


def _apart(order: np.ndarray, rotations: np.ndarray) -> list[int]:
    """The first POLISHED of an order that are not close to one before."""
    chosen: list[int] = []
    for k in order:
        if all(np.trace(rotations[k] @ rotations[c].T) < 1 + 2 * np.cos(np.radians(25)) for c in chosen):
            chosen.append(int(k))
        if len(chosen) == POLISHED:
            break
    return chosen


def _score(
    rotation: np.ndarray, outline: np.ndarray, cloud: LabelledPoints, known: Outlines, cells: LabelCells
) -> float:
    camera, error = known.fit(outline, rotation, cloud.points)
    return cells.overlap(camera, cloud) - FRONTIER * error / known.size


def _refined(
    rotation: np.ndarray, outline: np.ndarray, cloud: LabelledPoints, known: Outlines, cells: LabelCells
) -> tuple[np.ndarray, float]:
    from scipy.optimize import minimize
    from scipy.spatial.transform import Rotation

    def turned(vector: Any) -> np.ndarray:
        return Rotation.from_rotvec(vector).as_matrix() @ rotation

    simplex = np.concatenate([np.zeros((1, 3)), TURN * np.eye(3)])
    options: Any = {"initial_simplex": simplex, "maxfev": EVALUATIONS, "xatol": 2e-3, "fatol": 1e-5}

    def lost(vector: Any) -> Any:
        return -_score(turned(vector), outline, cloud, known, cells)

    found: Any = minimize(lost, np.zeros(3), method="Nelder-Mead", options=options)
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

    def overlap(self, camera: Orthographic, cloud: LabelledPoints) -> float:
        """LabelCells whose label is that of the nearest point, over cells in which either shows something."""
        column, row = np.floor((camera.project(cloud.points) + 0.5) / self.pixels).astype(np.int32).T
        inside = (row >= 0) & (row < self.labels.shape[0]) & (column >= 0) & (column < self.labels.shape[1])
        farthest_first = np.argsort(-camera.depth(cloud.points)[inside])
        drawn = np.zeros(self.labels.shape, np.int16)
        drawn[row[inside][farthest_first], column[inside][farthest_first]] = cloud.labels[inside][farthest_first]
        either = (drawn > 0) | (self.labels > 0)
        lost = int((~inside).sum()) / max(len(inside), 1) * int(either.sum())
        return float(((drawn == self.labels) & either).sum() / (either.sum() + lost))


def cloud_of(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray) -> LabelledPoints:
    """The middles of a mesh's faces."""
    return LabelledPoints(vertices[faces].mean(axis=1).astype(np.float64), (face_part + 1).astype(np.int16))


def known_outlines(images: Sequence[PartImage], cameras: Sequence[Orthographic]) -> Outlines:
    """Outlines of images whose cameras are known."""
    return Outlines.of([image.silhouette for image in images], cameras)
