"""Scales and shifts of orthographic cameras whose directions are known, from silhouettes alone.

Along the axis that two views share, the silhouettes of one rigid body reach from the same lowest to the same highest
coordinate (the frontier points). Each pair of views gives two such equations, parallel views four; they are linear in
1 / scale and the shift of each camera.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.orthographic import Orthographic

SHARED = 0.05  # least sine of the angle between two views that have one shared axis, not two


def align(silhouettes: Sequence[np.ndarray], rotations: Sequence[np.ndarray]) -> list[Orthographic]:
    """Cameras of masks (h, w) bool taken with these rotations; the first has scale 1 and its silhouette's middle at
    the origin.

    What no silhouette tells (the offset along the view of the first) is set to the smallest.
    """
    outlines = [outline_of(mask) for mask in silhouettes]
    middle = (outlines[0].min(axis=0) + outlines[0].max(axis=0)) / 2
    # world plane coordinates of camera i: a_i * pixel + b_i; unknowns (a, b_column, b_row) of all cameras but the first
    rows, right = [], []
    for j in range(1, len(rotations)):
        for i in range(j):
            for axis in _shared(rotations[i], rotations[j]):
                for row, value in _equations(i, j, axis, rotations, outlines, middle):
                    rows.append(row)
                    right.append(value)
    count = 3 * (len(rotations) - 1)
    solution = np.linalg.lstsq(np.array(rows).reshape(-1, count), np.array(right), rcond=1e-9)[0] if rows else []
    cameras = [Orthographic(rotations[0], 1.0, middle)]
    for k, rotation in enumerate(rotations[1:]):
        a, *b = solution[3 * k : 3 * k + 3]
        scale = 1 / a if a > 1e-6 else 1.0
        cameras.append(Orthographic(rotation, float(scale), -scale * np.array(b)))
    return cameras


def frontier_error(silhouettes: Sequence[np.ndarray], cameras: Sequence[Orthographic]) -> float:
    """Root mean square, in world units, by which silhouettes end at different coordinates along shared axes."""
    outlines = [outline_of(mask) for mask in silhouettes]
    errors = []
    for j in range(1, len(cameras)):
        for i in range(j):
            for axis in _shared(cameras[i].rotation, cameras[j].rotation):
                ends = [
                    _ends((outlines[k] - c.shift) / c.scale, c.rotation, axis)
                    for k, c in ((i, cameras[i]), (j, cameras[j]))
                ]
                errors.extend(np.subtract(*ends))
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else 0.0


def outline_of(mask: np.ndarray) -> np.ndarray:
    """Convex hull (n, 2) of the pixels of a mask as (column, row)."""
    from scipy.spatial import ConvexHull, QhullError

    rows, columns = np.nonzero(mask)
    pixels = np.stack([columns, rows], axis=1).astype(np.float64)
    try:
        return pixels[ConvexHull(pixels).vertices]
    except (QhullError, ValueError):
        return pixels


def _shared(first: np.ndarray, second: np.ndarray) -> list[np.ndarray]:
    """World axes (3,) that lie in the image planes of both rotations."""
    axis = np.cross(first[2], second[2])
    length = np.linalg.norm(axis)
    return [first[0], first[1]] if length < SHARED else [axis / length]


def _ends(plane: np.ndarray, rotation: np.ndarray, axis: np.ndarray) -> np.ndarray:
    along = plane @ (rotation[:2] @ axis)
    return np.array([along.min(), along.max()])


def _equations(i, j, axis, rotations, outlines, middle):
    """Both ends along one shared axis of views i < j as (row, right side)."""
    count = 3 * (len(rotations) - 1)
    ends, directions = [], []
    for k in (i, j):
        directions.append(rotations[k][:2] @ axis)
        ends.append(_ends(outlines[k] - (middle if k == 0 else 0), rotations[k], axis))
    for end in range(2):
        row, value = np.zeros(count), 0.0
        for k, sign, w, e in ((i, 1.0, directions[0], ends[0][end]), (j, -1.0, directions[1], ends[1][end])):
            if k == 0:
                value -= sign * e
            else:
                row[3 * (k - 1) : 3 * k] += sign * np.array([e, *w])
        yield row, value


BOX = 0.15  # weight of the model's own box against an end of a silhouette


@dataclass(frozen=True, eq=False)
class Outlines:
    """Silhouettes of known cameras as points of the world on their image planes, to fit one more camera to."""

    planes: tuple[np.ndarray, ...]  # (n, 2) each: in-plane world coordinates of an outline
    rotations: tuple[np.ndarray, ...]
    size: float  # of the largest outline

    @classmethod
    def of(cls, silhouettes: Sequence[np.ndarray], cameras: Sequence[Orthographic]) -> Outlines:
        """Those of masks (h, w) and their cameras; of parallel views only the first counts."""
        planes: list[np.ndarray] = []
        rotations: list[np.ndarray] = []
        for mask, camera in zip(silhouettes, cameras, strict=True):
            if all(np.linalg.norm(np.cross(camera.rotation[2], r[2])) >= SHARED for r in rotations):
                planes.append((outline_of(mask) - camera.shift) / camera.scale)
                rotations.append(camera.rotation)
        size = max(float(np.ptp(plane, axis=0).max()) for plane in planes)
        return cls(tuple(planes), tuple(rotations), size)

    def fit(
        self, outline: np.ndarray, rotations: np.ndarray, corners: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Scales (n,) and shifts (n, 2) of the cameras with rotations (n, 3, 3) that fit an outline (m, 2) of
        `outline_of` best, and the root mean square errors (n,) of the ends of silhouettes along shared axes, in the
        world. Where silhouettes do not tell, the box of a model with these corners (k, 3) does.
        """
        systems, targets, weights = [], [], []
        for plane, other in zip(self.planes, self.rotations, strict=True):
            for axes, weight in shared_by(other, rotations):
                w = np.einsum("nij,nj->ni", rotations[:, :2], axes)
                ends, goal = _ends_along(outline, w), _ends_along(plane, axes @ other[:2].T)
                for end in range(2):
                    systems.append(np.column_stack([ends[end], w]))
                    targets.append(goal[end])
                    weights.append(weight)
        told = len(systems)
        box = np.einsum("kj,nij->nki", corners, rotations[:, :2])
        for side in range(2):
            for pick in (np.min, np.max):
                row = np.array([pick(outline[:, side]), *np.eye(2)[side]])
                systems.append(np.broadcast_to(row, (len(rotations), 3)))
                targets.append(pick(box[:, :, side], axis=1))
                weights.append(np.full(len(rotations), BOX))
        system, target, weight = np.stack(systems, axis=1), np.stack(targets, axis=1), np.stack(weights, axis=1)
        solution = np.einsum("nuk,nk->nu", np.linalg.pinv(system * weight[..., None]), target * weight)
        error = (np.einsum("nku,nu->nk", system, solution) - target)[:, :told] * weight[:, :told]
        extent = float(np.ptp(outline, axis=0).max())
        a, b = solution[:, 0], solution[:, 1:]
        scales = np.where(a * extent > 1e-3 * self.size, 1 / np.where(a > 0, a, 1.0), extent / self.size)
        spread = np.sqrt((error**2).sum(axis=1) / np.maximum(weight[:, :told].sum(axis=1), 1))
        return scales, -scales[:, None] * b, spread


def shared_by(other: np.ndarray, rotations: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """`_shared` of one rotation with each of many: axes (n, 3) and whether they count (n,), twice."""
    axes = np.cross(other[2], rotations[:, 2])
    length = np.linalg.norm(axes, axis=1)
    parallel = (length < SHARED)[:, None]
    first = np.where(parallel, other[0], axes / np.maximum(length, SHARED)[:, None])
    return [(first, np.ones(len(rotations))), (np.broadcast_to(other[1], first.shape), parallel[:, 0] * 1.0)]


def _ends_along(plane: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and the largest coordinate (n,) of points (m, 2) along axes (n, 2)."""
    along = axes @ plane.T
    return along.min(axis=1), along.max(axis=1)
