"""Images of an animal whose pixels say to which part they belong, and the tree of the parts."""

from __future__ import annotations

from collections.abc import Sequence
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
    matches: dict[str, np.ndarray] = field(default_factory=dict)  # name of a point -> (column, row)

    def mask(self, part: int) -> np.ndarray:
        """Pixels (h, w) bool of a part."""
        return self.labels == part + 1

    @property
    def silhouette(self) -> np.ndarray:
        """Pixels (h, w) bool of the animal."""
        return self.labels != BACKGROUND

    def gives(self, part: int) -> bool:
        """Whether the image is meant to give the part its shape."""
        return self.aspects is None or part in self.aspects


def seen_by(images: Sequence[PartImage], part: int) -> list[int]:
    """Indices of the images that show a part."""
    return [k for k, image in enumerate(images) if image.mask(part).any()]
