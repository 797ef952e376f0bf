"""Is a silhouette an occluding rim, where the surface turns away (a solid), or a cut edge (a sheet)? Posterior from
generated scenes.

A logistic regression on features of picture and mask. The label of a generated scene is not what it was made as, but
which prior shape serves better: 1 when the balloon at `relief` of its height has less error of its normals than the
balloon.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf.energy import cell_normals
from ipcli.models.brdf.evaluation import inside, normal_error
from ipcli.models.brdf.grid import inflate, normals
from ipcli.models.brdf.solid import Pictured

FEATURES = (
    "shading explained by light",
    "shading explained by light of order 3",
    "shading explained by position",
    "rim explained by its direction",
    "gradient at the rim",
    "variation",
    "darker at the rim",
    "solidity",
    "rectangularity",
    "circularity",
    "vertices",
    "straight share",
    "corner share",
)
STRAIGHT = 0.12  # of the perimeter: sides of the polygon that are longer count as straight


@dataclass(frozen=True, eq=False)
class Judge:
    """P(sheet) = 1 / (1 + exp(-(w . (1, x, x^2)))) of standardised features x."""

    weights: np.ndarray  # (1 + 2 f,)
    mean: np.ndarray  # (f,)
    spread: np.ndarray  # (f,)

    def sheet(self, features: np.ndarray) -> np.ndarray:
        """Posterior (...) that the silhouette is a cut edge, of features (..., f)."""
        return 1 / (1 + np.exp(-np.clip(_design(features, self.mean, self.spread) @ self.weights, -30, 30)))


def _design(features: np.ndarray, mean: np.ndarray, spread: np.ndarray) -> np.ndarray:
    x = np.clip((features - mean) / spread, -3, 3)
    return np.concatenate([np.ones((*x.shape[:-1], 1)), x, x * x - 1], axis=-1)


def learn(features: np.ndarray, labels: np.ndarray, ridge: float = 40.0) -> Judge:
    """Ridge logistic regression of labels (n,) in [0, 1] on features (n, f), by Newton's method.

    The ridge is heavier than cross-validation on generated scenes asks for: photographs differ from them
    (`experiments/brdf/rims.py`).
    """
    mean, spread = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-6)
    x = _design(features, mean, spread)
    hold = ridge * np.diag([1e-6] + [1.0] * (x.shape[1] - 1))
    w = np.zeros(x.shape[1])
    for _ in range(50):
        p = 1 / (1 + np.exp(-np.clip(x @ w, -30, 30)))
        step = np.linalg.solve((x.T * (p * (1 - p))) @ x + hold, x.T @ (labels - p) - hold @ w)
        w = w + step
        if np.abs(step).max() < 1e-9:
            break
    return Judge(w, mean, spread)


def accuracy(features: np.ndarray, labels: np.ndarray, folds: int = 10) -> float:
    """Share of right answers on scenes (n) that were not learnt from, every `folds`-th in turn."""
    right = np.zeros(len(labels), bool)
    for fold in range(folds):
        held = np.arange(len(labels)) % folds == fold
        if held.any() and not held.all():
            right[held] = (learn(features[~held], labels[~held]).sheet(features[held]) > 0.5) == (labels[held] > 0.5)
    return float(right.mean())


def better_as_sheet(mask: np.ndarray, true_normals: np.ndarray, relief: float) -> bool:
    """Whether the flattened balloon of a mask (h, w) has less error against normals (h, w, 3) than the balloon."""
    balloon, where = inflate(mask), inside(mask)
    flattened, whole = (normal_error(normals(a * balloon, mask), true_normals, where) for a in (relief, 1.0))
    return flattened < whole


def features(picture: Pictured) -> np.ndarray:
    """All `FEATURES` (f,) of a picture on its grid."""
    return np.array([*_of_picture(picture), *_of_mask(picture.grid.mask)])


def _of_picture(picture: Pictured) -> list[float]:
    grid, intensity = picture.grid, picture.intensity
    n = cell_normals(grid, picture.inflated)
    rows, columns = np.nonzero(grid.mask)
    at = grid.on_cells(np.stack([columns, rows], axis=-1).astype(float))
    at = (at - at.mean(axis=0)) / max(float(at.std()), 1e-9)
    rim = n[:, 2] < 0.6
    angle = np.arctan2(n[:, 1], n[:, 0])
    waves = np.stack([f(k * angle) for k in (1, 2, 3) for f in (np.cos, np.sin)] + [np.ones(len(n))], axis=-1)
    slope = np.hypot(*_gradient(picture))
    edge = _edge(grid.mask)
    middle = ~edge
    return [
        _explained(_harmonics(n, 2), intensity),
        _explained(_harmonics(n, 3), intensity),
        _explained(_cubic(at), intensity),
        _explained(waves[rim], intensity[rim]) if rim.sum() > 12 else 0.0,
        float(np.log((slope[edge].mean() + 1e-3) / (slope[middle].mean() + 1e-3)))
        if edge.any() and middle.any()
        else 0.0,
        float(intensity.std() / max(intensity.mean(), 1e-9)),
        float(np.log((intensity[rim].mean() + 0.05) / (intensity[~rim].mean() + 0.05)))
        if rim.any() and not rim.all()
        else 0.0,
    ]


def _explained(basis: np.ndarray, values: np.ndarray) -> float:
    """Share of the mean absolute deviation that least squares on a basis (c, k) takes away."""
    left = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    return 1 - float(np.abs(left).mean() / max(np.abs(values - np.median(values)).mean(), 1e-9))


def _harmonics(n: np.ndarray, order: int) -> np.ndarray:
    """All monomials of n up to an order: the same space as the spherical harmonics up to it."""
    x, y, z = n.T
    powers = [(a, b, c) for a in range(order + 1) for b in range(order + 1) for c in (0, 1) if a + b + c <= order]
    return np.stack([x**a * y**b * z**c for a, b, c in powers], axis=-1)


def _cubic(at: np.ndarray) -> np.ndarray:
    return np.stack([at[:, 0] ** a * at[:, 1] ** b for a in range(4) for b in range(4 - a)], axis=-1)


def _gradient(picture: Pictured) -> tuple[np.ndarray, np.ndarray]:
    values = picture.colour.mean(axis=1)
    return picture.grid.slope_x @ values, picture.grid.slope_y @ values


def _edge(mask: np.ndarray, width: float = 3.0) -> np.ndarray:
    """Cells within `width` pixels of the outline."""
    from scipy.ndimage import distance_transform_edt

    depth = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    whole = mask[:-1, :-1] & mask[:-1, 1:] & mask[1:, :-1] & mask[1:, 1:]
    mean = (depth[:-1, :-1] + depth[:-1, 1:] + depth[1:, :-1] + depth[1:, 1:]) / 4
    return mean[whole] <= width


def _of_mask(mask: np.ndarray) -> list[float]:
    import cv2

    outlines = cv2.findContours(np.pad(mask, 1).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    outline = max(outlines, key=len)
    smooth = _smoothed(outline[:, 0].astype(np.float32))
    area, perimeter = max(cv2.contourArea(smooth), 1.0), max(cv2.arcLength(smooth, True), 1.0)
    hull = max(cv2.contourArea(cv2.convexHull(smooth)), 1.0)
    width, height = cv2.minAreaRect(smooth)[1]
    polygon = cv2.approxPolyDP(smooth, 0.02 * perimeter, True)[:, 0]
    sides = np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1)
    return [
        area / hull,
        area / max(width * height, 1.0),
        4 * np.pi * area / perimeter**2,
        float(np.log(max(len(polygon), 1))),
        float(sides[sides > STRAIGHT * perimeter].sum() / perimeter),
        _corners(polygon),
    ]


def _smoothed(points: np.ndarray, width: int = 5) -> np.ndarray:
    """A closed outline (k, 2) without the stairs of its pixels."""
    from scipy.ndimage import uniform_filter1d

    return uniform_filter1d(points, width, axis=0, mode="wrap").astype(np.float32)


def _corners(polygon: np.ndarray) -> float:
    """Share of the vertices of a polygon (k, 2) that turn by 50 to 130 degrees."""
    step = np.roll(polygon, -1, axis=0) - polygon
    heading = np.arctan2(step[:, 1], step[:, 0])
    turn = np.abs((heading - np.roll(heading, 1) + np.pi) % (2 * np.pi) - np.pi)
    return float(((turn > np.radians(50)) & (turn < np.radians(130))).mean()) if len(polygon) else 0.0
