"""One camera for each image of the reference pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipcli.geometry.orthographic import Orthographic, named
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal import by_parts, whole
from ipcli.models.animal.cameras import align
from ipcli.models.animal.parameters import Modelling
from ipcli.models.animal.search import cloud_of, find_camera, known_outlines
from ipcli.progress import Progress, silent

ROUGH = 56  # voxels of the models that cameras are found with
ROUNDS = 2  # of finding the cameras without a name again, each with a model from all others
FIRST = "left"  # taken for granted when no view has a name


def placed(
    images: Sequence[PartImage],
    tree: PartTree,
    params: Modelling,
    progress: Progress = silent,
) -> list[Orthographic]:
    """Cameras of all images, in their order. The first image with a named view has scale 1 (in pixels of its own).

    Named views get their scale and shift from the silhouettes; the others are found one after the other from a rough
    model of those that are known, and once more each from a model of all others.
    """
    views = [image.view for image in images]
    if not any(views):
        views[0] = FIRST
    order = [k for k, view in enumerate(views) if view] + [k for k, view in enumerate(views) if not view]
    anchors = [k for k in order if views[k]]
    rotations = [named(str(views[k])) for k in anchors]
    cameras = dict(zip(anchors, align([images[k].silhouette for k in anchors], rotations), strict=True))
    searched = [k for k in order if not views[k]]
    rough = replace(params, volume=replace(params.volume, voxels=ROUGH, steps=6))
    work = [k for _ in range(ROUNDS if len(searched) > 1 or _is_flat(rotations) else 1) for k in searched]
    for done, k in enumerate(work):
        progress(done / len(work), f"camera of {images[k].name}")
        others = [other for other in order if other in cameras and other != k]
        seen, known = [images[o] for o in others], [cameras[o] for o in others]
        surface = whole.model(seen, known, tree, rough)
        if params.search != "image":
            cameras[k] = by_parts.find_camera(images[k], surface, list(zip(seen, known, strict=True)), params.search)
            continue
        cloud = cloud_of(surface.vertices, surface.faces, surface.face_part)
        cameras[k], _ = find_camera(images[k], cloud, known_outlines(seen, known))
    return [cameras[k] for k in range(len(images))]


def _is_flat(rotations: Sequence[np.ndarray]) -> bool:
    """Whether all views look along one line, so that nothing tells the depth."""
    return bool(all(abs(rotation[2] @ rotations[0][2]) > 0.9 for rotation in rotations))
