"""What the model of an animal is compared with: visual hulls, the whole mask inflated, the thesis as printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipcli.geometry import level_sets
from ipcli.geometry.orthographic import Orthographic
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal import rims, whole
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import Inflation, Modelling

Mesh = tuple[np.ndarray, np.ndarray]
STEPS = 20  # of flow for the rounded hull


def visual_hull(
    images: Sequence[PartImage], cameras: Sequence[Orthographic], voxels: int, *, is_rounded: bool = False
) -> Mesh:
    """The visual hull as a mesh; `is_rounded` by mean curvature flow that keeps the rims."""
    grid = whole.grid_of(images, cameras, voxels)
    shots = whole.shots_of(images, cameras, grid)
    outlines = [shot.sight.silhouette_distance(shot.image.silhouette) for shot in shots]
    phi = np.maximum.reduce(outlines)
    if is_rounded:
        phi = rims.round_off(phi, phi, [shot.sight for shot in shots], outlines, STEPS)
    return level_sets.mesh(phi, grid.spacing, grid.origin)


def whole_mask(image: PartImage, camera: Orthographic, params: Inflation) -> Mesh:
    """The silhouette of one image inflated as if it were one part, in the plane of depth 0."""
    vertices, faces = inflate(image.silhouette, params).surface()
    return camera.lift(vertices[:, :2], vertices[:, 2] / camera.scale), faces


def as_printed(images: Sequence[PartImage], cameras: Sequence[Orthographic], tree: PartTree, params: Modelling) -> Mesh:
    """The thesis' steps: load (6.4) as printed, the union of all aspects of each part and of all parts, smoothed.

    Aspects are put where the images see them, in the middle of what the labels allow, which is kinder than (6.10).
    """
    printed = replace(params.inflation, load="printed", gain=gain_of(images, params.inflation))
    fields = []
    grid = whole.grid_of(images, cameras, params.volume.voxels)
    shots = whole.shots_of(images, cameras, grid)
    lifted = {key: aspect.picture for key, aspect in whole.lift_all(images, tree, printed).items()}
    carved = whole.carve(shots, tree)
    for part in range(len(tree)):
        for shot in shots:
            if (shot.image.name, part) in lifted and (carved[part] < 0).any():
                fields.append(_aspect_field(carved[part], shot, lifted[shot.image.name, part]))
    phi = level_sets.flow(np.minimum.reduce(fields), params.volume.rounding * level_sets.STABLE)
    return level_sets.mesh(phi, grid.spacing, grid.origin)


def _aspect_field(carved: np.ndarray, shot: whole.Shot, heights: np.ndarray) -> np.ndarray:
    from ipcli.models.animal.parts import spans

    middle, _ = spans(carved, shot.sight)
    height = shot.sight.sample(heights / np.float32(shot.sight.pixels), 0.0)
    return np.where(height > 0, np.abs(shot.sight.depth - middle.ravel()[shot.sight.ray]) - height, np.float32(8.0))


def gain_of(images: Sequence[PartImage], params: Inflation) -> float:
    """The one gain with which the printed load lifts the largest silhouette as high as the root of a membrane does.

    (6.4) has no unit that fits all sizes: without a gain of this kind every model would be flat, or far too thick.
    """
    image = max(images, key=lambda i: int(i.silhouette.sum()))
    heights = [
        float(inflate(image.silhouette, replace(params, load=load, gain=1.0)).picture.max())
        for load in ("sqrt-poisson", "printed")
    ]
    return heights[0] / max(heights[1], 1e-9)
