"""The volume of each part: what the silhouettes allow, what the labels allow, and no thicker than its aspect.

A voxel may belong to a part only if every image either shows the part there, or shows another part that lies in front
of it. That cuts the visual hull apart along the labels. Between the views the part is rounded by its best aspect, put
in the middle of what is left and scaled so that it just fills the outlines in the other views (of views that lean to
the aspect's, slice by slice: see `slices`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.voxels import FAR, Sight, hull
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.aspects import completed
from ipcli.models.animal.slices import Slices, fitted

OUTSIDE = np.float32(1e3)  # voxels
ROUNDS = 2  # of carving: what is cut off one part uncovers others
PARALLEL = np.cos(np.radians(25.0))  # of two views: closer ones say nothing of each other's depth
SAME_LINE = 5e-4  # sine of the angle between views that look along one line
SPARE = 5.0  # voxels around the animal that belong to its grid
ACROSS = np.cos(np.radians(80.0))  # of two views: closer ones lean
ALONG = 0.96  # cosine of the angle between views that count as one direction
SHOWN = 0.2  # of the largest area in which a part is seen: less does not tell its outline
EVIDENCE = 30  # voxels of a part that must show themselves to be asked for its thickness
THINNEST, THICKEST = 0.3, 2.0  # times the aspect's own thickness


@dataclass(frozen=True, eq=False)
class Shot:
    """An image of the reference pose with its camera and how that sees the grid."""

    image: PartImage
    camera: Orthographic
    sight: Sight


def best_image(shots: Sequence[Shot], part: int) -> int:
    """Index of the shot that shows most of a part; -1 when none does."""
    areas = [shot.image.mask(part).sum() / shot.camera.scale**2 for shot in shots]
    return int(np.argmax(areas)) if max(areas) > 0 else -1


def is_one_line(directions: Sequence[np.ndarray]) -> bool:
    """Whether all directions (3,), of length 1, are those of one line, so that nothing tells the depth along it."""
    return all(np.linalg.norm(np.cross(directions[0], other)) < SAME_LINE for other in directions[1:])


def all_lean(directions: Sequence[np.ndarray]) -> bool:
    """Whether no two of the directions (n, 3), of length 1, are across each other, so that all hulls lean."""
    return bool((np.abs(np.array(directions) @ np.array(directions).T) > ACROSS).all())


def untold_depth(images: Sequence[PartImage], cameras: Sequence[Orthographic]) -> float | None:
    """How deep an animal is taken to be when all views look along one line: the shorter side of its first silhouette,
    in world units. None when views along two lines tell.
    """
    if not is_one_line([camera.direction for camera in cameras]):
        return None
    rows, columns = np.nonzero(images[0].silhouette)
    return float(min(np.ptp(rows), np.ptp(columns)) / cameras[0].scale)


def carve(shots: Sequence[Shot], tree: PartTree) -> list[np.ndarray]:
    """The field (nx, ny, nz) in voxels of where each part may be; OUTSIDE everywhere for a part that no shot shows."""
    whole = hull([s.sight for s in shots], [s.image.silhouette for s in shots])
    depth = untold_depth([s.image for s in shots], [s.camera for s in shots])
    if depth is not None:  # rays are cut at a plane across the view, not where they happen to leave the grid
        half = depth * shots[0].camera.scale / shots[0].sight.pixels / 2
        whole = np.maximum(whole, np.abs(shots[0].sight.depth) - np.float32(half + SPARE))
    owned = [[shot.sight.silhouette_distance(shot.image.mask(k)) for k in range(len(tree))] for shot in shots]
    seen = [shot.sight.nearest(shot.image.labels) for shot in shots]
    fields = []
    for part in range(len(tree)):
        best = best_image(shots, part)
        if best < 0:
            fields.append(np.full(whole.shape, OUTSIDE))
            continue
        shot = shots[best]
        mask = completed(shot.image.mask(part), shot.image.silhouette)
        fields.append(np.maximum(whole, shot.sight.silhouette_distance(mask)))
    for _ in range(ROUNDS):
        fields = [_carved(part, fields, shots, owned, seen) for part in range(len(tree))]
    return fields


def _carved(
    part: int,
    fields: Sequence[np.ndarray],
    shots: Sequence[Shot],
    owned: Sequence[Sequence[np.ndarray]],
    seen: Sequence[np.ndarray],
) -> np.ndarray:
    """The field of one part without what every shot rules out."""
    field = fields[part]
    for shot, own, labels in zip(shots, owned, seen, strict=True):
        allowed = own[part]
        for other in range(len(fields)):
            behind = labels == other + 1
            if other == part or not behind.any():
                continue
            first = shot.sight.least(shot.sight.depth, fields[other] < 0)
            gap = first[shot.sight.ray[behind]] - shot.sight.depth[behind]  # negative: behind the other part
            allowed[behind] = np.minimum(allowed[behind], np.clip(gap, -OUTSIDE, OUTSIDE))
        field = np.maximum(field, allowed)
    return field


def evident(shots: Sequence[Shot], part: int) -> np.ndarray:
    """The field (nx, ny, nz) of where a part shows itself: within its own mask in some view of each direction.

    Views along one line count as one direction, and a direction that shows little of the part counts not at all. What
    is hidden is left out here: it has no outline that could tell how thick it is.
    """
    areas = [shot.image.mask(part).sum() / shot.camera.scale**2 for shot in shots]
    groups: list[list[int]] = []
    for k, shot in enumerate(shots):
        direction = shot.camera.direction
        same = [g for g in groups if abs(direction @ shots[g[0]].camera.direction) > ALONG]
        if same:
            same[0].append(k)
        else:
            groups.append([k])
    shown = [g for g in groups if max(areas[k] for k in g) > SHOWN * max(areas)]
    fields = [
        np.minimum.reduce([shots[k].sight.silhouette_distance(shots[k].image.mask(part)) for k in group])
        for group in shown
    ]
    return np.maximum.reduce(fields)


def rounded(
    fields: Sequence[np.ndarray], shots: Sequence[Shot], heights: Mapping[tuple[str, int], np.ndarray]
) -> list[np.ndarray]:
    """Each part's field made no thicker than its best aspect.

    `heights` has the half thickness (h, w) in pixels by name of image and part, as `aspects.lift_all` makes them.
    """
    results = []
    for part, field in enumerate(fields):
        lifted = [shot for shot in shots if (shot.image.name, part) in heights]
        best = best_image(lifted, part) if lifted else -1
        if best < 0 or not (field < 0).any():
            results.append(field)
            continue
        shot = lifted[best]
        shown = np.maximum(field, evident(shots, part))
        told = shown if (shown < 0).sum() >= EVIDENCE else field
        results.append(np.maximum(field, thickness(told, part, shot, heights[shot.image.name, part], shots)))
    return results


def thickness(field: np.ndarray, part: int, shot: Shot, heights: np.ndarray, shots: Sequence[Shot]) -> np.ndarray:
    """A field (nx, ny, nz) that is negative where a point lies within the aspect, put in the middle of `field`."""
    sight = shot.sight
    height = sight.sample(heights / np.float32(sight.pixels), 0.0)
    cosines = [abs(other.camera.direction @ shot.camera.direction) for other in shots]
    beside = [other for other, cosine in zip(shots, cosines, strict=True) if cosine <= PARALLEL]
    leaning = [o for o, cosine in zip(shots, cosines, strict=True) if ACROSS < cosine <= PARALLEL]
    leaning = [other for other in leaning if other.image.mask(part).any()]
    if leaning and len(leaning) == len(beside):
        field, factor = upright(field, part, shot, heights, height, leaning)
        middle, _ = spans(field, sight)
    else:
        middle, half = spans(field, sight)
        factor = fitting_factor(field, shot, height, half, [other.camera.direction for other in beside])
    away = np.abs(sight.depth - middle.ravel()[sight.ray])
    return (away - factor * height).astype(np.float32)


def upright(
    field: np.ndarray, part: int, shot: Shot, heights: np.ndarray, height: np.ndarray, leaning: Sequence[Shot]
) -> tuple[np.ndarray, float]:
    """The field (nx, ny, nz) without what lies beside the aspect where its outlines in leaning views put it, and how
    much thicker than the aspect the part is; `height` are the heights (h, w) at all points, in voxels.
    """
    camera, sight = shot.camera, shot.sight
    spacing = sight.pixels / camera.scale
    ratios: list[float] = []
    cut = field
    for other in leaning:
        slices = Slices.of(heights, camera, part, other.image, other.camera, spacing)
        own = slices.ratios().tolist()
        ratios += own
        factor = float(np.clip(fitted(own), THINNEST, THICKEST))
        depths = slices.depths(factor)
        if depths is None:
            continue
        x, y = camera.rotation[:2] @ slices.axis / camera.scale
        along = x * (sight.columns - camera.shift[0]) + y * (sight.rows - camera.shift[1])
        middle = (depths / spacing).astype(np.float32)[slices.number(along)]
        cut = np.maximum(cut, np.abs(sight.depth - middle) - np.float32(factor) * height - 1)
    factor = float(np.clip(fitted(ratios), THINNEST, THICKEST))
    return (cut if (cut < 0).any() else field), factor


def spans(field: np.ndarray, sight: Sight) -> tuple[np.ndarray, np.ndarray]:
    """Middle and half length (cells), in voxels, of where each ray is inside a field; the middle smoothed and carried
    on to rays beside it.
    """
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    near = sight.least(sight.depth, field < 0)
    far = -sight.least(-sight.depth, field < 0)
    known = (near < FAR / 2).reshape(sight.cells)
    middle = np.where(known, (near + far).reshape(sight.cells) / 2, 0.0)
    half = np.where(known, (far - near).reshape(sight.cells) / 2 + 0.5, 0.0)
    weight = gaussian_filter(known.astype(np.float64), 2.0)
    smooth = gaussian_filter(middle * known, 2.0) / np.maximum(weight, 1e-9)
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return smooth[tuple(nearest)].astype(np.float32), half


def fitting_factor(
    field: np.ndarray, shot: Shot, height: np.ndarray, half: np.ndarray, directions: Sequence[np.ndarray]
) -> float:
    """How much thicker than its aspect a part is, so that it just fills its outline in the other views.

    Along the axis that two views share each slice of the part must somewhere be as thick as the slice of its hull: the
    median over the slices of hull thickness over aspect thickness. 1 when no other view tells.
    """
    inside = field < 0
    ratios: list[float] = []
    for direction in directions:
        axis = np.cross(direction, shot.camera.direction)
        axis /= np.linalg.norm(axis)
        sight = shot.sight
        along = (axis @ shot.camera.rotation[0]) * sight.columns + (axis @ shot.camera.rotation[1]) * sight.rows
        slices = np.round((along[inside] - along[inside].min()) / sight.pixels).astype(int)
        thick, lifted = np.zeros(slices.max() + 1), np.zeros(slices.max() + 1)
        np.maximum.at(thick, slices, half.ravel()[sight.ray[inside]])
        np.maximum.at(lifted, slices, height[inside])
        told = lifted > 0.5
        ratios.extend(thick[told] / lifted[told])
    return float(np.clip(np.median(ratios), THINNEST, THICKEST)) if ratios else 1.0
