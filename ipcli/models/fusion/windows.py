"""Rectangles of images, and which one of a view can say anything about a given one of the reference.

A view is looked through once, in blocks: a block and the range of its depths span a piece of space, and the box that
this piece covers in the reference image is that of its eight corners. A rectangle of the reference needs the blocks
whose boxes meet it, and no pixel more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ipcli.geometry.cameras import transform
from ipcli.measurements.views import View, relative

BLOCK = 128  # pixels along a side
ROUND = 1.0  # pixels by which boxes are wider than computed: the nearest pixel is half a pixel away
LOOKED_UP = 64  # pixels around the blocks that are taken too: a map tells by less where its surface is looked up


@dataclass(frozen=True)
class Window:
    """A rectangle of the image."""

    rows: slice
    columns: slice

    def of(self, image: np.ndarray) -> np.ndarray:
        """That part of an image, as a view of it."""
        return image[self.rows, self.columns]

    def of_optional(self, image: np.ndarray | None) -> np.ndarray | None:
        """That part of an image, None of none."""
        return None if image is None else self.of(image)

    def wider(self, margin: int) -> Window:
        """The rectangle with a margin; it may reach over the end of the image, as slices do."""
        return Window(*(slice(max(s.start - margin, 0), s.stop + margin) for s in (self.rows, self.columns)))

    def within(self, outer: Window) -> Window:
        """The same rectangle counted from the corner of another."""
        pairs = ((self.rows, outer.rows), (self.columns, outer.columns))
        return Window(*(slice(own.start - other.start, own.stop - other.start) for own, other in pairs))

    def camera_of(self, intrinsics: np.ndarray) -> np.ndarray:
        """Intrinsics (3, 3) of the camera that sees but this rectangle."""
        own = intrinsics.copy()
        own[:2] -= np.outer((self.columns.start, self.rows.start), intrinsics[2])
        return own

    def camera(self, view: View) -> View:
        """The view that sees but this rectangle."""
        return replace(
            view,
            depth=self.of(view.depth),
            intrinsics=self.camera_of(view.intrinsics),
            confidence=self.of_optional(view.confidence),
            image=self.of_optional(view.image),
            truth=self.of_optional(view.truth),
        )


def tiles(shape: tuple[int, int], side: int) -> list[Window]:
    """Tiles that cover an image (h, w), without margin."""
    edges = [[slice(start, min(start + side, n)) for start in range(0, n, side)] for n in shape]
    return [Window(rows, columns) for rows, columns in product(*edges)]


@dataclass(frozen=True, eq=False)
class Landing:
    """Where the blocks of a view land in the reference image."""

    boxes: np.ndarray  # (by, bx, 4) first and last row, first and last column; NaN for a block without depth

    @classmethod
    def of(cls, view: View, reference: View) -> Landing:
        """Of a view, looked through once."""
        near, far = (_of_blocks(view.depth, least) for least in (np.fmin, np.fmax))
        rows, columns = (
            [range(0, n, BLOCK), [min(at + BLOCK, n) for at in range(0, n, BLOCK)]] for n in view.depth.shape
        )
        corners = np.empty((*near.shape, 8, 3))
        for at, (low, left, depth) in enumerate(product((0, 1), (0, 1), (near, far))):
            corners[..., at, 0] = np.asarray(columns[left])[None] - 0.5
            corners[..., at, 1] = np.asarray(rows[low])[:, None] - 0.5
            corners[..., at, 2] = depth
        rays = (
            np.concatenate([corners[..., :2], np.ones((*corners.shape[:-1], 1))], axis=-1)
            @ np.linalg.inv(view.intrinsics).T
        )
        there = transform(relative(reference, view), (rays * corners[..., 2:]).reshape(-1, 3)).reshape(corners.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = (there @ reference.intrinsics.T)[..., 1::-1] / there[..., 2:]
        least, most = pixels.min(axis=2) - ROUND, pixels.max(axis=2) + ROUND
        behind = (there[..., 2] <= 0).any(axis=-1)  # a piece about the camera's centre may land anywhere
        least[behind], most[behind] = -np.inf, np.inf
        return cls(np.stack([least[..., 0], most[..., 0], least[..., 1], most[..., 1]], axis=-1))

    def window(self, of_reference: Window) -> Window:
        """The rectangle of the view that may land in that of the reference, and LOOKED_UP around it; of one pixel if
        nothing can.
        """
        top, bottom, left, right = np.moveaxis(self.boxes, -1, 0)
        rows, columns = of_reference.rows, of_reference.columns
        meets = (top <= rows.stop) & (bottom >= rows.start) & (left <= columns.stop) & (right >= columns.start)
        if not meets.any():
            return Window(slice(0, 1), slice(0, 1))
        ends = [np.flatnonzero(meets.any(axis=axis))[[0, -1]] for axis in (1, 0)]
        return Window(*(slice(int(first) * BLOCK, int(last + 1) * BLOCK) for first, last in ends)).wider(LOOKED_UP)


def _of_blocks(depth: np.ndarray, least: np.ufunc) -> np.ndarray:
    """The least, or greatest, depth of each block (by, bx); NaN without any."""
    starts = [np.arange(0, n, BLOCK) for n in depth.shape]
    return least.reduceat(least.reduceat(depth, starts[0], axis=0), starts[1], axis=1).astype(np.float64)


Part = Callable[[int, Window], View]  # a rectangle of view k, as the view that sees but that


@dataclass(frozen=True, eq=False)
class Excerpts(Sequence[View]):
    """Of each view (K) what can land in a rectangle of the reference, read when it is asked for."""

    part: Part
    landings: Sequence[Landing]
    window: Window

    def __len__(self) -> int:
        return len(self.landings)

    def __getitem__(self, k: Any) -> Any:
        return self.part(k, self.landings[k].window(self.window))
