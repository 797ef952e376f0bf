"""Images of an animal whose pixels say to which part they belong, and the tree of the parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

BACKGROUND = 0
NONE = -1  # parent of the root


@dataclass(frozen=True)
class PartTree:
    """Names of the parts and, for each, the index of its parent (NONE for the one root); flatness of each."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    flatness: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.flatness:
            object.__setattr__(self, "flatness", (1.0,) * len(self.names))

    def __len__(self) -> int:
        return len(self.names)

    @property
    def root(self) -> int:
        """Index of the part without a parent."""
        return self.parents.index(NONE)

    def downwards(self) -> list[int]:
        """Indices so that every part comes after its parent."""
        order = [self.root]
        for part in order:
            order.extend(k for k, parent in enumerate(self.parents) if parent == part)
        return order


@dataclass(frozen=True, eq=False)
class PartImage:
    """One image: labels (h, w) int16, 0 background and k + 1 where part k is seen.

    `view` is a name of ipcli.geometry.orthographic.NAMED, or None when it is not known from where the image was taken.
    Images of the reference pose fix the pose of the model; all images may give shape to the parts in `aspects` (None:
    every part that is seen).
    """

    name: str
    labels: np.ndarray
    view: str | None = None
    is_reference: bool = True
    aspects: tuple[int, ...] | None = None
    picture: np.ndarray | None = None  # (h, w, 3) uint8

    def mask(self, part: int) -> np.ndarray:
        """Pixels (h, w) bool of a part."""
        return self.labels == part + 1

    @property
    def silhouette(self) -> np.ndarray:
        """Pixels (h, w) bool of the animal."""
        return self.labels != BACKGROUND

    def outlines(self) -> dict[int, np.ndarray]:
        """Pixels (m, 2) float64, as (column, row), of each part that lie beside the background, if it has any."""
        from scipy.ndimage import binary_dilation

        rim = np.where(binary_dilation(~self.silhouette), self.labels, BACKGROUND)
        return {int(label) - 1: pixels_of(rim == label) for label in np.unique(rim[rim != BACKGROUND])}

    def gives(self, part: int) -> bool:
        """Whether the image is meant to give the part its shape."""
        return self.aspects is None or part in self.aspects


@dataclass(frozen=True, eq=False)
class PartMatches:
    """Points (n, 2, 2) of one part that two images both show, as (column, row) in the first and in the second."""

    part: int
    images: tuple[str, str]
    points: np.ndarray


def pixels_of(mask: np.ndarray) -> np.ndarray:
    """The pixels (m, 2) float64 of a mask as (column, row), row by row."""
    return np.argwhere(mask)[:, ::-1].astype(np.float64)


def seen_by(images: Sequence[PartImage], part: int) -> list[int]:
    """Indices of the images that show a part."""
    return [k for k, image in enumerate(images) if image.mask(part).any()]


LEAST_PIXELS = 60  # of a mask that tells a shape


def oddities(images: Sequence[PartImage], tree: PartTree) -> list[str]:
    """What is odd about masks and may spoil the model, a sentence each: holes, several blobs, too few pixels, masks at
    the border of their image, parts that no image of the reference pose shows.
    """
    from scipy.ndimage import binary_fill_holes, label

    found = []
    for image in images:
        for part, name in enumerate(tree.names):
            mask = image.mask(part)
            if not mask.any():
                continue
            where, blobs = f"{name} in {image.name}", label(mask, np.ones((3, 3)))[1]
            if mask.sum() < LEAST_PIXELS:
                found.append(f"{where}: only {int(mask.sum())} pixels, {LEAST_PIXELS} and more tell a shape")
            if blobs > 1:
                found.append(f"{where}: {blobs} blobs; only the largest gives shape")
            if (binary_fill_holes(image.silhouette) & ~image.silhouette & binary_fill_holes(mask)).any():
                found.append(f"{where}: a hole through which the background shows")
            if mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any():
                found.append(f"{where}: touches the border of the image, so its outline may be cut")
    shown = {part for image in images if image.is_reference for part in range(len(tree)) if image.mask(part).any()}
    return found + [
        f"{tree.names[p]}: no image of the reference pose shows it" for p in range(len(tree)) if p not in shown
    ]
