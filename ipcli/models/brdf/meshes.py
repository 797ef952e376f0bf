"""Triangle meshes as surfaces to picture: rays along -z, one a pixel, with the normals of the vertices between them."""

from __future__ import annotations

import numpy as np

from ipcli.geometry.meshes import vertex_normals
from ipcli.geometry.raycast import Caster, Mesh
from ipcli.models.brdf.surfaces import ImplicitSurface

FILL = 0.9  # half the longest side of the mesh, in halves of the picture


def seen(vertices: np.ndarray, faces: np.ndarray, side: int, rotation: np.ndarray, name: str) -> ImplicitSurface:
    """The front of a mesh (n, 3), (m, 3) turned by a rotation (3, 3), orthographic, as a picture (side, side) sees it.

    Normals are those of the vertices, interpolated, where they face the viewer; else that of the triangle, turned to
    it. Heights are in pixels.
    """
    turned = (vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2) @ rotation.T
    turned = turned - (turned.min(axis=0) + turned.max(axis=0)) / 2
    turned = turned * (FILL / np.abs(turned[:, :2]).max())
    height, triangle, weights, flat = Caster(Mesh(turned, faces)).from_front(side)
    mask = np.isfinite(height)
    corners = vertex_normals(turned, faces)[faces[triangle[mask]]]
    normals = np.einsum("nk,nkc->nc", weights[mask], corners)
    face = flat[mask] * np.where(flat[mask][:, 2:] < 0, -1.0, 1.0)
    normals = np.where((normals * face).sum(axis=1, keepdims=True) < 0, -normals, normals)  # faces wound the other way
    normals = np.where(normals[:, 2:] > 0.01, normals, face + [0, 0, 1e-6])
    shown = np.full((*mask.shape, 3), np.nan)
    shown[mask] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return ImplicitSurface(mask, height * side / 2, shown, False, name)
