"""Cameras from single parts, as the thesis assembles them (6.4): each part is looked for on its own.

"view" searches a part's silhouette, "twopoint" the least contour generator energy (6.10), and "hybrid" the silhouette
among the views of least energy. Every part proposes views of the whole image; its camera is the proposal under which
the parts lie, by their middles, where the image shows them. The search over all labels at once (`search`) is better;
these are kept to compare with.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry.distances import to_surface
from ipcli.geometry.meshes import edges
from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.raycast import Mesh
from ipcli.measurements.part_images import PartImage, pixels_of
from ipcli.models.animal.aspects import completed
from ipcli.models.animal.part_views import PartOutline, Silhouette
from ipcli.models.animal.two_point import OutlinePoints, SurfaceSamples, views
from ipcli.models.animal.whole import PartedSurface

PROPOSED = 4  # views that a part proposes
SHORTLIST = 5000  # pairs of points of least energy that "hybrid" looks at
SAMPLES = 1000  # points of a part that pairs are made of
LEAST_PIXELS = 60  # of a part's mask
FINENESS = 0.5  # cell of a silhouette, and how near to the surface of the whole a part is no cut, in sides of triangles


def find_camera(
    image: PartImage, surface: PartedSurface, known: Sequence[tuple[PartImage, Orthographic]], search: str
) -> Orthographic:
    """The camera of an image that sees a rough model of known images as the image shows it.

    NoSolution if no part shows enough of its outline.
    """
    whole = (surface.vertices.astype(np.float64), surface.faces)
    side = FINENESS * spacing_of(*whole)
    scale = scale_of(image, known)
    rotations = []
    for part, (vertices, faces) in surface.parts.items():
        if image.mask(part).sum() >= LEAST_PIXELS:
            body = Mesh(vertices.astype(np.float64), faces)
            skin = to_surface(body.vertices, whole) < side
            rotations += proposals(image, part, body, skin, scale, side, search)
    if not rotations:
        raise NoSolution(f"{image.name}: no part shows enough of its own outline; --search image needs none")
    points = spread(*whole)
    cameras = [shape_matched(image, rotation, points, scale, side) for rotation in rotations]
    middles = {part: vertices.mean(axis=0) for part, (vertices, _) in surface.parts.items()}
    return min(cameras, key=lambda camera: misplaced(camera, image, middles))


def proposals(
    image: PartImage, part: int, body: Mesh, skin: np.ndarray, scale: float, side: float, search: str
) -> list[np.ndarray]:
    """Rotations (3, 3) under which one part, a closed mesh, looks like its mask; `skin` (n,) are the vertices of it
    that are no cut, `scale` the image's in pixels a unit of the world, and `side` that of a cell of silhouettes.
    """
    mask = completed(image.mask(part), image.silhouette)
    outline = PartOutline(spread(body.vertices, body.faces), side, Silhouette.of(pixels_of(mask) / scale, side))
    if search == "view":
        return outline.views(PROPOSED)
    samples = SurfaceSamples.of(body.vertices, body.faces)
    chosen = np.flatnonzero(skin)
    samples = samples.chosen(chosen[:: max(len(chosen) // SAMPLES, 1)])
    try:
        pair = OutlinePoints.of(image, part, scale).pair(samples) if len(chosen) else None
    except ValueError:  # too thin a mask for a smooth contour
        pair = None
    if pair is None:
        return []
    rotations, _ = views(samples, pair, body, 1 if search == "twopoint" else SHORTLIST)
    return outline.refined(rotations, PROPOSED) if search == "hybrid" else list(rotations)


def spread(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertices of a mesh and the middles of its faces and their sides, (n, 3)."""
    sides = np.unique(edges(faces), axis=0)
    return np.concatenate([vertices, vertices[faces].mean(axis=1), vertices[sides].mean(axis=1)])


def spacing_of(vertices: np.ndarray, faces: np.ndarray) -> float:
    """The longest side of nearly all triangles, which is about that of a voxel."""
    corners = vertices[faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    return float(np.percentile(sides, 90))


def scale_of(image: PartImage, known: Sequence[tuple[PartImage, Orthographic]]) -> float:
    """Pixels a unit of the world: the root of the silhouette's area over the mean one of known images."""
    areas = [other.silhouette.sum() / camera.scale**2 for other, camera in known]
    return float(np.sqrt(image.silhouette.sum() / np.mean(areas)))


def shape_matched(
    image: PartImage, rotation: np.ndarray, points: np.ndarray, scale: float, side: float
) -> Orthographic:
    """The camera with a rotation whose silhouette of points (n, 3) has the image's middle and area: the similarity that
    the view leaves. Both silhouettes are counted in cells of one side, with about this `scale`.
    """
    shown = Silhouette.of(pixels_of(image.silhouette) / scale, side)
    seen = Silhouette.of(points @ rotation[:2].T, side)
    matched = scale * shown.extent / seen.extent
    return Orthographic(rotation, matched, scale * shown.middle - matched * seen.middle)


def misplaced(camera: Orthographic, image: PartImage, middles: dict[int, np.ndarray]) -> float:
    """Mean distance in pixels of the parts' middles (3,), as a camera sees them, from those of their masks."""
    away = [
        np.linalg.norm(camera.project(middle) - pixels_of(image.mask(part)).mean(axis=0))
        for part, middle in middles.items()
        if image.mask(part).any()
    ]
    return float(np.mean(away)) if away else 0.0
