"""Features of a surface that may tell where it is looked at, from points and normals alone.

Fine ones are of each vertex among its nearest neighbours. Coarse ones are computed on sites, one a cell of an even
grid, so that unevenly sampled vertices count by area. How far apart vertices lie predicts recorded gaze all by itself,
since a wide triangle is hit by more gaze rays: the spacing is that baseline and never learnt from.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.geometry.meshes import vertex_normals

SPACING = "vertex spacing"
SITES = 2500
COUNTS = (8, 16, 32, 64)  # nearest neighbours of the fine features
SCALES = (0.02, 0.04, 0.08)  # shares of the diagonal of the bounding box
PART = 0.15  # scale of a part of an object
REACH = 2.2  # spreads at which a Gaussian is cut off
NEIGHBOURS = 4  # sites from which a vertex takes its value


@dataclass(frozen=True, eq=False)
class Sites:
    """Evenly spread sites (s, 3) with normals (s, 3), and the diagonal of all vertices."""

    places: np.ndarray
    normals: np.ndarray
    diagonal: float

    def at(self, vertices: np.ndarray, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Values (s,) by name interpolated to vertices (n, 3) from the nearest sites, by inverse distance."""
        from scipy.spatial import cKDTree

        count = min(NEIGHBOURS, len(self.places))
        distance, near = cKDTree(self.places).query(vertices, count)
        distance, near = distance.reshape(-1, count), near.reshape(-1, count)
        weight = 1 / (distance + 1e-3 * self.diagonal)
        weight /= weight.sum(axis=1, keepdims=True)
        return {name: (weight * part[near]).sum(axis=1) for name, part in values.items()}


def sites(vertices: np.ndarray, normals: np.ndarray, count: int = SITES) -> Sites:
    """About `count` sites at most of vertices (n, 3) with normals (n, 3)."""
    low = vertices.min(axis=0)
    diagonal = max(float(np.linalg.norm(vertices.max(axis=0) - low)), 1e-12)
    small, large = diagonal * 1e-3, diagonal
    for _ in range(24):
        side = np.sqrt(small * large)
        number = len(np.unique(_codes(vertices, low, side)))
        small, large = (small, side) if number <= count else (side, large)
    _, cell = np.unique(_codes(vertices, low, large), return_inverse=True)
    cell = cell.reshape(-1)
    size = np.bincount(cell)[:, None]
    places, directions = (
        np.stack([np.bincount(cell, part[:, k]) for k in range(3)], axis=1) / size for part in (vertices, normals)
    )
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    directions = np.where(length > 1e-9, directions / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])
    return Sites(places, directions, diagonal)


def _codes(vertices: np.ndarray, low: np.ndarray, side: float) -> np.ndarray:
    index = np.floor((vertices - low) / side).astype(np.int64)
    return (index[:, 0] << 42) + (index[:, 1] << 21) + index[:, 2]


def smoother(ground: Sites, scale: float) -> Any:
    """Rows of a sparse matrix (s, s): Gaussian weights of spread `scale` diagonals over the sites that face the same
    half of space, summing to 1.
    """
    from scipy import sparse
    from scipy.spatial import cKDTree

    spread = scale * ground.diagonal
    tree = cKDTree(ground.places)
    near = tree.sparse_distance_matrix(tree, REACH * spread, output_type="coo_matrix")
    alike = np.einsum("ni,ni->n", ground.normals[near.row], ground.normals[near.col]) > -0.2
    weight = np.exp(-(near.data**2) / (2 * spread**2)) * alike
    own = np.arange(len(ground.places))
    rows, columns = np.concatenate([near.row, own]), np.concatenate([near.col, own])
    data = np.concatenate([np.where(near.row == near.col, 0, weight), np.ones(len(own))])
    matrix = sparse.csr_array((data, (rows, columns)), shape=(len(own), len(own)))
    return sparse.csr_array(sparse.diags_array(1 / matrix.sum(axis=1)) @ matrix)


def features(vertices: np.ndarray, normals: np.ndarray) -> dict[str, np.ndarray]:
    """All features of vertices (n, 3) with unit normals (n, 3) by name, each (n,); y is up."""
    ground = sites(vertices, normals)
    part = smoother(ground, PART)
    coarse = _place(ground, part) | _bends(ground, part)
    return _fine(vertices, normals) | ground.at(vertices, coarse)


def _fine(vertices: np.ndarray, normals: np.ndarray) -> dict[str, np.ndarray]:
    """How the surface bends about each vertex among its nearest neighbours, whatever their distance; and that."""
    from scipy.spatial import cKDTree

    most = min(COUNTS[-1], len(vertices) - 1)
    distance, near = cKDTree(vertices).query(vertices, most + 1)
    found = {SPACING: distance[:, min(COUNTS[0], most)]}
    for count in COUNTS:
        k = min(count, most)
        size = np.maximum(distance[:, k], 1e-12)
        offset = vertices - vertices[near[:, 1 : k + 1]].mean(axis=1)
        found[f"convexity of {count}"] = np.einsum("ni,ni->n", normals, offset) / size
        found[f"roughness of {count}"] = 1 - np.linalg.norm(normals[near[:, : k + 1]].mean(axis=1), axis=1)
        found[f"lopsidedness of {count}"] = np.linalg.norm(offset, axis=1) / size
    return found


def _place(ground: Sites, part: Any) -> dict[str, np.ndarray]:
    """Where on the object a site is, and which way it faces."""
    places, normals = ground.places, ground.normals
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    away = places - places.mean(axis=0)
    far = np.linalg.norm(away, axis=1)
    low, high = places[:, 1].min(), places[:, 1].max()
    return {
        "height": (places[:, 1] - low) / max(high - low, 1e-12),
        "nearness to the centroid": -far,
        "nearness to the axis": -np.linalg.norm(away[:, [0, 2]], axis=1),
        "nearness to the plane x": -np.abs(places[:, 0] - middle[0]),
        "nearness to the plane z": -np.abs(places[:, 2] - middle[2]),
        "faces up": normals[:, 1],
        "faces outward": np.einsum("ni,ni->n", normals, away) / np.maximum(far, 1e-12),
        "slenderness": -np.diff(part.indptr).astype(np.float64),
        "overhang": places[:, 1] - part @ places[:, 1],
    }


def _bends(ground: Sites, part: Any) -> dict[str, np.ndarray]:
    """How the surface bends at each scale: convexity, curvature, roughness, and Lee's mesh saliency."""
    places, normals = ground.places, ground.normals
    found: dict[str, np.ndarray] = {}
    bends: list[np.ndarray] = []
    for scale in SCALES:
        smooth = smoother(ground, scale)
        mean = smooth @ places
        convexity = np.einsum("ni,ni->n", normals, places - mean) / (scale * ground.diagonal)
        bends.append(convexity)
        found[f"convexity {scale:g}"] = convexity
        found[f"curvature {scale:g}"] = np.abs(convexity)
        found[f"roughness {scale:g}"] = 1 - np.linalg.norm(smooth @ normals, axis=1)
        found[f"flatness {scale:g}"] = -_variation(places, smooth)
    lee = sum(np.abs(a - b) for a, b in zip(bends[:-1], bends[1:], strict=True))
    found["Lee's mesh saliency"] = np.asarray(lee)
    for name in ("convexity 0.02", "curvature 0.02", "roughness 0.02", "roughness 0.08", "Lee's mesh saliency"):
        found[f"{name}, part"] = part @ found[name]
    return found


def _variation(places: np.ndarray, smooth: Any) -> np.ndarray:
    """Surface variation (s,): the least eigenvalue of the weighted covariance over the sum of all."""
    mean = smooth @ places
    outer = np.einsum("ni,nj->nij", places, places).reshape(len(places), 9)
    covariance = (smooth @ outer).reshape(-1, 3, 3) - np.einsum("ni,nj->nij", mean, mean)
    values = np.maximum(np.linalg.eigvalsh(covariance), 0)
    return values[:, 0] / np.maximum(values.sum(axis=1), 1e-30)


def ranks(values: np.ndarray) -> np.ndarray:
    """Values (n,) as their ranks in 0..1, equal ones alike, so that objects can be compared."""
    from scipy.stats import rankdata

    return (rankdata(values) - 0.5) / len(values)


def upright_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) of the vertices of a mesh; up where there are none."""
    normals = vertex_normals(vertices, faces)
    return np.where(normals.any(axis=1, keepdims=True), normals, [0.0, 1.0, 0.0])
