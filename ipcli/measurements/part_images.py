"""Images of an animal whose pixels say to which part they belong, and the tree of the parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

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

    `view` is a word that ipcli.geometry.orthographic.of_view knows, or None when it is not known from where the image
    was taken. Images of the reference pose fix the pose of the model; all images may give shape to the parts in
    `aspects` (None: every part that is seen). `dropped`: pixels of each mask of its file that the project leaves out.
    """

    name: str
    labels: np.ndarray
    view: str | None = None
    is_reference: bool = True
    aspects: tuple[int, ...] | None = None
    picture: np.ndarray | None = None  # (h, w, 3) uint8
    dropped: Mapping[str, int] = field(default_factory=dict)

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
LEAST_DROPPED = 0.02  # of the pixels of an animal; less than that of a mask that was left out is no matter
LEAST_HOLE = 5  # pixels; a smaller one is a flaw of the mask, and closed when it is lifted
FEW, BLOBS, HOLE, BORDER, MISSING, DROPPED = (
    "too few pixels to tell a shape",
    "several blobs, of which only the largest gives shape",
    "a hole through which the background shows",
    "cut by the border of the image",
    "no image of the reference pose shows it",
    "left out, so that the model has a gap there",
)


@dataclass(frozen=True)
class Oddity:
    """What is odd about one mask: its kind, where it is, in words, and whether another image makes up for it."""

    kind: str
    where: str
    words: str
    is_harmless: bool = False


def oddities(images: Sequence[PartImage], tree: PartTree) -> list[Oddity]:
    """What is odd about masks and may spoil the model: holes, several blobs, too few pixels, masks at the border of
    their image, parts that no image of the reference pose shows, and much of the animal that is left out.

    Few pixels or several blobs do no harm where another image shows the part in one piece that tells its shape.
    """
    from scipy.ndimage import binary_fill_holes, label

    shown = [(image, part) for image in images for part in range(len(tree)) if image.mask(part).any()]
    blobs = {(image.name, part): label(image.mask(part), np.ones((3, 3)))[1] for image, part in shown}
    whole = {
        (image.name, part)
        for image, part in shown
        if blobs[image.name, part] == 1 and image.mask(part).sum() >= LEAST_PIXELS
    }
    found = []
    for image, part in shown:
        mask, where = image.mask(part), f"{tree.names[part]} in {image.name}"
        is_known = any(other == part and name != image.name for name, other in whole)
        if mask.sum() < LEAST_PIXELS:
            words = f"only {int(mask.sum())} pixels, {LEAST_PIXELS} and more tell a shape"
            found.append(Oddity(FEW, where, words, is_known))
        if blobs[image.name, part] > 1:
            words = f"{blobs[image.name, part]} blobs; only the largest gives shape"
            found.append(Oddity(BLOBS, where, words, is_known))
        hole = binary_fill_holes(image.silhouette) & ~image.silhouette & binary_fill_holes(mask)
        if hole.sum() >= LEAST_HOLE:
            found.append(Oddity(HOLE, where, HOLE))
        if mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any():
            found.append(Oddity(BORDER, where, "touches the border of the image, so its outline may be cut"))
    found += [
        Oddity(DROPPED, f"{name} in {image.name}", f"{count} pixels of the animal are {DROPPED}")
        for image in images
        for name, count in image.dropped.items()
        if count > LEAST_DROPPED * image.silhouette.sum()
    ]
    known = {part for image, part in shown if image.is_reference}
    return found + [Oddity(MISSING, tree.names[p], MISSING) for p in range(len(tree)) if p not in known]


def told(found: Sequence[Oddity]) -> list[str]:
    """Every oddity in a sentence."""
    return [f"{odd.where}: {odd.words}" for odd in found]


def folded(found: Sequence[Oddity]) -> list[str]:
    """Those that may do harm, a line a kind with the number and the names of the masks."""
    lines = []
    for kind in (FEW, BLOBS, HOLE, BORDER, MISSING, DROPPED):
        same = [odd for odd in found if odd.kind == kind and not odd.is_harmless]
        if len(same) == 1:
            lines += told(same)
        elif same:
            things = "parts" if kind == MISSING else "masks"
            lines.append(f"{len(same)} {things}: {kind}: {', '.join(odd.where for odd in same)}")
    return lines
