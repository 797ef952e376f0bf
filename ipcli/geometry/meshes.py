"""Triangle meshes: their edges, areas, normals and volume, and what lies inside of them."""

from __future__ import annotations

import numpy as np


def edges(faces: np.ndarray) -> np.ndarray:
    """The sides (3 m, 2) of triangles (m, 3), three of each in turn, the lower vertex first."""
    return np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)


def across(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vectors (m, 3) across triangles, twice as long as their area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Areas (m,) of triangles."""
    return np.linalg.norm(across(vertices, faces), axis=1) / 2


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) of vertices (n, 3), those of their triangles (m, 3) weighed by area; zero where there are
    none.
    """
    of_face, total = across(vertices, faces), np.zeros((len(vertices), 3))
    for k in range(3):
        np.add.at(total, faces[:, k], of_face)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """The volume that a closed mesh encloses."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(abs(np.einsum("na,na->", a, np.cross(b, c))) / 6)


def contains(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether a mesh winds around each of points (n, 3): it may cut itself, and have small holes."""
    import igl

    corners = np.ascontiguousarray(faces, np.int64)
    return igl.fast_winding_number(np.ascontiguousarray(vertices, np.float64), corners, points) > 0.5
