"""Whether a mesh is closed, and how thick it is where it is thinnest."""

from __future__ import annotations

from typing import Any

import numpy as np

SAMPLES = 4000  # faces looked at for thickness
STEP = 1e-4  # of the diagonal: how far below the surface a ray starts


def soundness(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Any]:
    """Watertight (each edge in two faces, turned oppositely), volume, pieces, faces, and the thickness along the inward
    normal: the least, and the one that 1 % of the faces are below. Lengths in the unit of the vertices (n, 3).
    """
    import trimesh

    body = trimesh.Trimesh(vertices, faces, process=False)
    least, hundredth = thickness(vertices, faces)
    return {
        "watertight": bool(body.is_watertight and body.is_winding_consistent),
        "volume": float(body.volume),
        "pieces": int(body.body_count),
        "faces": len(faces),
        "thinnest": least,
        "thickness_1_percent": hundredth,
    }


def thickness(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, float]:
    """Least and 1 % lowest distance from the middle of a face straight inwards to the next face; NaN for an open mesh
    in which no ray meets one.
    """
    from ipcli.geometry import open3d

    core = open3d.load().core
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = float(np.linalg.norm(high - low)) or 1.0
    unit = (vertices - (low + high) / 2) / extent
    scene = open3d.load().t.geometry.RaycastingScene()
    scene.add_triangles(core.Tensor(unit.astype(np.float32)), core.Tensor(faces.astype(np.uint32)))
    corners = unit[faces[:: -(-len(faces) // SAMPLES)]]
    inwards = -np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(inwards, axis=1, keepdims=True)
    sound = length[:, 0] > 1e-12
    inwards, middles = (inwards / np.maximum(length, 1e-30))[sound], corners.mean(axis=1)[sound]
    rays = np.concatenate([middles + STEP * inwards, inwards], axis=1).astype(np.float32)
    met = scene.cast_rays(core.Tensor(rays))["t_hit"].numpy()
    met = (met[np.isfinite(met)] + STEP) * extent
    return (float(met.min()), float(np.percentile(met, 1))) if met.size else (float("nan"), float("nan"))
