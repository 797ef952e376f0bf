"""One camera for each image of the reference pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ipcli.geometry.orthographic import Orthographic, of_view
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal import by_parts, whole
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.cameras import align
from ipcli.models.animal.frontiers import adjusted
from ipcli.models.animal.parameters import Modelling
from ipcli.models.animal.search import cloud_of, find_camera
from ipcli.progress import Progress, silent

ROUGH = 56  # voxels of the models that cameras are found with
TRIANGLES = 400  # of a mask in such a model
ROUNDS = 2  # of finding the cameras without a name again, each with a model from all others
OBLIQUE = 0.9  # cosine of the angle between two views, below which one tells the depth of the other
FIRST = "left"  # taken for granted when no view has a name


def placed(
    images: Sequence[PartImage],
    tree: PartTree,
    params: Modelling,
    progress: Progress = silent,
) -> list[Orthographic]:
    """Cameras of all images, in their order. The first image with a named view has scale 1 (in pixels of its own).

    Named views get their scale and shift from the silhouettes; the others are found one after the other from a rough
    model of those that are known, and once more each from a model of all others. After each, all that were found are
    adjusted together.
    """
    views = [image.view for image in images]
    if not any(views):
        views[0] = FIRST
    anchors = [k for k, view in enumerate(views) if view]
    rotations = [of_view(str(views[k])) for k in anchors]
    cameras = dict(zip(anchors, align([images[k].silhouette for k in anchors], rotations), strict=True))
    searched = [k for k, view in enumerate(views) if not view]
    if searched:
        _search(images, tree, params, cameras, searched, progress)
    return [cameras[k] for k in range(len(images))]


def _search(
    images: Sequence[PartImage],
    tree: PartTree,
    params: Modelling,
    cameras: dict[int, Orthographic],
    searched: list[int],
    progress: Progress,
) -> None:
    """Add the cameras of all images that are searched."""
    rough = replace(
        params,
        inflation=replace(params.inflation, triangles=min(TRIANGLES, params.inflation.triangles)),
        volume=replace(params.volume, voxels=ROUGH, steps=6),
    )
    heights = {key: a.picture for i in images for key, a in lift_all([i], tree, rough.inflation).items()}

    def find(k: int) -> tuple[Orthographic, float]:
        others = [other for other in cameras if other != k]
        seen, known = [images[o] for o in others], [cameras[o] for o in others]
        fields, shots, grid = whole.parts_of(seen, known, tree, heights, rough.volume)
        surface = whole.surface(fields, shots, grid, rough.volume)
        if params.search != "image":
            return by_parts.find_camera(images[k], surface, list(zip(seen, known, strict=True)), params.search), 0.0
        return find_camera(images[k], cloud_of(surface.vertices, surface.faces, surface.face_part), seen, known)

    order = searched
    if len(searched) > 1 and params.search == "image" and _is_flat([*cameras.values()]):
        order = _deepest_first({k: find(k) for k in searched}, next(iter(cameras.values())))
    work = order * (ROUNDS if len(searched) > 1 else 1)
    for done, k in enumerate(work):
        progress(done / len(work), f"camera of {images[k].name}")
        cameras[k], _ = find(k)
        if params.search == "image" and not _is_flat([*cameras.values()]):
            seen, known = [images[o] for o in cameras], [*cameras.values()]
            better = adjusted(seen, known, [o in searched for o in cameras])
            cameras.update(zip(cameras, better, strict=True))


def _deepest_first(found: Mapping[int, tuple[Orthographic, float]], known: Orthographic) -> list[int]:
    """The order in which to find cameras when all that are known look along one line: first the one that fits best of
    those that look along another, since only it tells the depth; then by how well they fit.
    """
    order = sorted(found, key=lambda k: -found[k][1])
    return sorted(order, key=lambda k: abs(found[k][0].direction @ known.direction) > OBLIQUE)


def _is_flat(cameras: Sequence[Orthographic]) -> bool:
    """Whether all look along one line, so that nothing tells the depth."""
    return all(abs(camera.direction @ cameras[0].direction) > OBLIQUE for camera in cameras)
