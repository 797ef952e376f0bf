"""Part masks as an orthographic camera sees a labelled mesh, by ray casting: nearer parts hide those behind them."""

from __future__ import annotations

import numpy as np

from ipcli.geometry.orthographic import Orthographic

STANDOFF = 2.0  # extents of the mesh between the rays' start and its middle


def framed(vertices: np.ndarray, rotation: np.ndarray, longest: int, margin: int = 8) -> tuple[Orthographic, tuple]:
    """A camera with this rotation in whose image the vertices (n, 3) just fit, and its shape (rows, columns).

    The longer side of the object takes `longest` pixels; `margin` pixels are left free all around.
    """
    plane = vertices @ rotation[:2].T
    low, high = plane.min(axis=0), plane.max(axis=0)
    scale = longest / (high - low).max()
    columns, rows = np.ceil(scale * (high - low)).astype(int) + 2 * margin + 1
    return Orthographic(rotation, float(scale), margin - scale * low), (int(rows), int(columns))


def render(
    vertices: np.ndarray, faces: np.ndarray, face_labels: np.ndarray, camera: Orthographic, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Labels (h, w) int16 and depth (h, w) float32 of a mesh: for each pixel those of the first face that its ray
    meets, 0 and NaN where there is none. face_labels (m,) counts from 1.
    """
    first, depth = first_faces(vertices, faces, camera, shape)
    labels = np.zeros(shape, np.int16)
    labels[first >= 0] = face_labels[first[first >= 0]]
    return labels, depth


def first_faces(
    vertices: np.ndarray, faces: np.ndarray, camera: Orthographic, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """For each pixel the first face (h, w) int64 that its ray meets, -1 for none, and its depth (h, w) float32."""
    from ipcli.geometry import open3d

    core = open3d.load().core
    scene = open3d.load().t.geometry.RaycastingScene()
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    extent = float(np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0)))
    scene.add_triangles(
        core.Tensor(np.ascontiguousarray((vertices - middle) / extent, np.float32)),
        core.Tensor(np.ascontiguousarray(faces, np.uint32)),
    )
    v, u = np.mgrid[: shape[0], : shape[1]]
    start = camera.lift(np.stack([u, v], axis=-1).astype(np.float64), camera.depth(middle) - STANDOFF * extent)
    rays = np.concatenate([(start - middle) / extent, np.broadcast_to(camera.direction, start.shape)], axis=-1)
    hit = scene.cast_rays(core.Tensor(rays.astype(np.float32)))
    along = hit["t_hit"].numpy()
    met = np.isfinite(along)
    first = np.where(met, hit["primitive_ids"].numpy().astype(np.int64), -1)
    depth = np.full(shape, np.nan, np.float32)
    depth[met] = camera.depth(middle) + extent * (along[met] - STANDOFF)
    return first, depth
