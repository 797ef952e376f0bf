"""Triangle meshes as depth cameras see them: ray casting, and the two camera paths of the thesis' synthetic data
(4.5.2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipcli.geometry import meshes, open3d
from ipcli.geometry.cameras import rays

DISTANCE = 3.0  # of the orbiting camera from the centre of an object of radius 1
STEP = 2 * np.pi / 72  # of the orbit, radians
HEIGHT = 300.0  # of the flying camera above the lowest point of the scene
LOOKING = np.diag([1.0, -1.0, -1.0])  # cam_from_world rotation: against world z, world y up in the image
BEFORE = 4.0  # from where lines start that are looked along as a whole, in units of the mesh
BACKGROUND = 255  # grey level of the image where there is no surface


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh: vertices (n, 3) float64 and faces (m, 3) of indices into them."""

    vertices: np.ndarray
    faces: np.ndarray


class Caster:
    """A mesh ready for any number of views. The tree it builds holds float32: bring the mesh near the origin first."""

    def __init__(self, mesh: Mesh) -> None:
        self._core = open3d.load().core
        self._across = meshes.across(mesh.vertices, mesh.faces)
        self._scene = open3d.load().t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._core.Tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
            self._core.Tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
        )

    def view(
        self, shape: tuple[int, int], intrinsics: np.ndarray, cam_from_world: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Depth (h, w) float32 along the optical axis, NaN where no surface is hit, and the image (h, w, 3) uint8 that
        a lamp at the camera would give.
        """
        rotation, origin = cam_from_world[:3, :3], np.linalg.inv(cam_from_world)[:3, 3]
        directions = (
            rays(shape, intrinsics) @ rotation
        )  # in the world; z in the camera is 1, so t along them is the depth
        hit = self._scene.cast_rays(self._core.Tensor(self._packed(origin, directions)))
        depth = hit["t_hit"].numpy()
        depth = np.where(np.isfinite(depth), depth, np.nan).astype(np.float32)
        cosine = np.abs((hit["primitive_normals"].numpy() * directions).sum(-1)) / np.linalg.norm(directions, axis=-1)
        grey = np.where(np.isfinite(depth), np.round(225 * cosine), BACKGROUND).astype(np.uint8)
        return depth, np.repeat(grey[..., None], 3, axis=-1)

    def from_front(self, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What parallel rays along -z meet first in the square [-1, 1]^2 of side x side pixels, x right, y up.

        Height z (s, s), NaN where nothing is met; triangle (s, s) int, weights of its corners (s, s, 3) and its normal
        (s, s, 3).
        """
        axis = (np.arange(side) + 0.5) / side * 2 - 1
        x, y = np.meshgrid(axis, -axis)
        start = 4.0
        origin = np.stack([x, y, np.full_like(x, start)], axis=-1)
        hit = self._scene.cast_rays(
            self._core.Tensor(self._packed(origin, np.broadcast_to([0.0, 0.0, -1.0], origin.shape)))
        )
        away = hit["t_hit"].numpy().astype(np.float64)
        height = np.where(np.isfinite(away), start - away, np.nan)
        uv = hit["primitive_uvs"].numpy().astype(np.float64)
        weights = np.concatenate([1 - uv.sum(axis=-1, keepdims=True), uv], axis=-1)
        triangle = np.where(np.isfinite(away), hit["primitive_ids"].numpy().astype(np.int64), -1)
        return height, triangle, weights, hit["primitive_normals"].numpy().astype(np.float64)

    def deepest(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """The longest stretch (n,) inside the closed mesh, which lies within 1 of the origin, of whole lines through
        points (n, 3) in unit directions (n, 3).
        """
        start = points - ((points * directions).sum(axis=-1, keepdims=True) + BEFORE) * directions
        found = self._scene.list_intersections(self._core.Tensor(self._packed(start, directions)))
        ray, face, along = (found[key].numpy() for key in ("ray_ids", "primitive_ids", "t_hit"))
        order = np.lexsort((along, ray))
        ray, face, along = ray[order], face[order], along[order]
        enters = np.where((self._across[face] * directions[ray]).sum(axis=-1) < 0, 1, -1)
        wound = np.cumsum(enters)  # of all rays so far
        first = np.searchsorted(ray, ray)
        inside = (wound - wound[first] + enters[first])[:-1] > 0
        stretch = np.where(inside & (ray[1:] == ray[:-1]), np.diff(along), 0.0)
        deepest = np.zeros(len(points))
        np.maximum.at(deepest, ray[:-1], stretch)
        return deepest

    @staticmethod
    def _packed(origin: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return np.concatenate([np.broadcast_to(origin, directions.shape), directions], axis=-1).astype(np.float32)


def unit_sphere(mesh: Mesh, up: str = "y") -> Mesh:
    """The mesh turned so that its axis `up` is y, its bounding box centred at the origin, its farthest vertex at
    distance 1.
    """
    vertices = np.roll(mesh.vertices, 1 - "xyz".index(up), axis=1)  # cyclic, so that nothing is mirrored
    vertices = vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return replace(mesh, vertices=vertices / np.linalg.norm(vertices, axis=1).max())


def on_ground(mesh: Mesh) -> Mesh:
    """The mesh, z up, with the middle of its bounding box above the origin and its lowest vertex at z = 0."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return replace(mesh, vertices=mesh.vertices - [*(low + high)[:2] / 2, low[2]])


def offsets(views: int) -> np.ndarray:
    """Places (views,) along a path, in steps, from the one in the middle; of an even number, one more lies after it."""
    return np.arange(views) - (views - 1) // 2


def orbit(views: int, spacing: float) -> np.ndarray:
    """cam_from_world (views, 4, 4) of a camera at DISTANCE facing the origin, turning about y by `spacing` times STEP a
    view.
    """
    poses = np.tile(np.eye(4), (views, 1, 1))
    for pose, angle in zip(poses, offsets(views) * spacing * STEP, strict=True):
        c, s = np.cos(angle), np.sin(angle)
        pose[:3, :3] = LOOKING @ [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        pose[2, 3] = DISTANCE
    return poses


def strip(views: int, spacing: float) -> np.ndarray:
    """cam_from_world (views, 4, 4) of a camera at HEIGHT that faces straight down and moves along x by `spacing` a
    view.
    """
    poses = np.tile(np.eye(4), (views, 1, 1))
    poses[:, :3, :3] = LOOKING
    poses[:, 0, 3] = -spacing * offsets(views)
    poses[:, 2, 3] = HEIGHT
    return poses
