"""What makes a finished model doubtful, in sentences that name the likely cause and its cure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.geometry.orthographic import Orthographic, of_view
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.placing import OBLIQUE

FLAT = "all views look along one line, or nearly: the depth is a guess. Give an image from another direction"
LEAST_LIKE = 0.7  # share of pixels with the right part, below which an image and the model do not go together
LEAST_BENT = 0.6  # of another pose's model, bent: a wrong camera has less; what other individuals cost it does not tell


def beforehand(images: Sequence[PartImage]) -> list[str]:
    """What the views of the images of one pose tell before any work: that nothing tells the depth."""
    views = [image.view for image in images if image.view is not None]
    if len(images) > max(len(views), 1) or _lines([of_view(view)[2] for view in views]) > 1:
        return []
    if len(images) == 1:
        return ["one view alone: the depth, and all that it does not show, is a guess"]
    return [f"{', '.join(image.name for image in images)}: {FLAT}"]


def doubts(
    images: Sequence[PartImage],
    cameras: Sequence[Orthographic],
    tree: PartTree,
    overlaps: Sequence[float],
    face_part: np.ndarray,
    bent_overlap: float | None = None,
) -> list[str]:
    """Images that the model does not look like, declared parts that it lacks, views that do not tell the shape, and
    another pose that does not fit this one.

    `overlaps` (k,) are shares of pixels whose part agrees, `face_part` (m,) the part of each face of the model;
    `bent_overlap` the overlap of the other pose's model with the images once it was bent, if one was.
    """
    found = [
        f"{image.name}: the model shows the right part in only {100 * share:.0f} % of the pixels. Check the view of "
        "each image, and that left and right are the animal's"
        for image, share in zip(images, overlaps, strict=True)
        if share < LEAST_LIKE
    ]
    lost = [name for part, name in enumerate(tree.names) if part not in face_part]
    if lost:
        found.append(
            f"not in the model: {', '.join(lost)}. No image of the reference pose shows them, or the others leave them "
            "no room"
        )
    if bent_overlap is not None and bent_overlap < LEAST_BENT:
        found.append(
            f"the animal of the other pose, bent, covers only {100 * bent_overlap:.0f} % of the parts in the images. "
            "Check the view of each image, and see whether --other-pose ignore is better"
        )
    searched = [image.name for image in images if image.view is None]
    directions = [camera.direction for camera in cameras]
    named = [line for image, line in zip(images, directions, strict=True) if image.view is not None]
    if searched and len(images) > 1 and _lines(directions) < 2:
        found.append(f"{', '.join(searched)}: {FLAT}")
    if searched and _lines(named) < 2 and _lines(directions) == 2:
        found.append(
            f"{', '.join(searched)}: two lines of view do not tell the angle between them: the shape may be sheared. "
            "Give the view (a name, or angles as view = [40, 15]), or an image along a third line"
        )
    return found


def _lines(directions: Sequence[np.ndarray]) -> int:
    """Number of lines among directions (3,) of view, those that are nearly the same counted once."""
    lines: list[np.ndarray] = []
    for direction in directions:
        if all(abs(direction @ line) < OBLIQUE for line in lines):
            lines.append(direction)
    return len(lines)
