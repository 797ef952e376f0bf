"""Labelled meshes as pictures: shaded from around, and drawn over the images they were made from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.geometry.orthographic import looking
from ipcli.geometry.part_masks import first_faces, framed

COLOURS = np.array(
    [
        (222, 165, 92), (94, 140, 190), (196, 94, 88), (110, 168, 120), (150, 120, 180), (216, 190, 92),
        (104, 176, 176), (206, 130, 168), (150, 150, 110), (120, 110, 100), (170, 200, 110), (90, 110, 150),
    ],
    np.float64,
)  # fmt: skip
BEHIND = (36, 38, 43)
PAPER = (246, 245, 240)
SPARE = 6  # pixels around an animal over its images
UNSEEN = (150, 151, 156)
LIGHT = np.array([-0.45, -0.65, -0.6]) / np.linalg.norm([-0.45, -0.65, -0.6])


def colours_of(parts: np.ndarray | int) -> np.ndarray:
    """RGB (..., 3) float of parts by number."""
    return COLOURS[np.asarray(parts) % len(COLOURS)]


def shaded(
    vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray, rotation: np.ndarray, longest: int
) -> np.ndarray:
    """The mesh in the colours (m, 3) of its faces under a soft lamp, as (h, w, 3) uint8, seen with a rotation."""
    camera, shape = framed(vertices, rotation, longest)
    first, _ = first_faces(vertices, faces, camera, shape)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ rotation.T
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    lit = 0.25 + 0.35 * np.clip(-normals[:, 2], 0, 1) + 0.45 * (0.5 + 0.5 * normals @ LIGHT) ** 2
    painted = np.full((*shape, 3), BEHIND, np.float64)
    met = first >= 0
    painted[met] = colours[first[met]] * lit[first[met], None]
    return np.clip(painted, 0, 255).astype(np.uint8)


def turntable(
    vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray, count: int, longest: int
) -> list[np.ndarray]:
    """Pictures from `count` places around, a little from above; all of one size."""
    pictures = [shaded(vertices, faces, colours, looking(45 + 360 * k / count, 15.0), longest) for k in range(count)]
    height, width = (max(picture.shape[axis] for picture in pictures) for axis in (0, 1))
    return [_centred(picture, height, width, BEHIND) for picture in pictures]


def _centred(picture: np.ndarray, height: int, width: int, ground: tuple[int, int, int]) -> np.ndarray:
    canvas = np.full((height, width, 3), ground, np.uint8)
    top, left = (height - picture.shape[0]) // 2, (width - picture.shape[1]) // 2
    canvas[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
    return canvas


def painted_labels(labels: np.ndarray) -> np.ndarray:
    """A label image (h, w), 0 background, in the colours of its parts."""
    table = np.concatenate([[PAPER], colours_of(np.arange(max(int(labels.max(initial=0)), 1)))])
    return table[labels].astype(np.uint8)


def overlay(labels: np.ndarray, rendered: np.ndarray, picture: np.ndarray | None) -> np.ndarray:
    """The outlines of the model's parts over an image (or over its masks), (h, w, 3) uint8."""
    ground = painted_labels(labels).astype(np.float64)
    if picture is not None:
        ground = np.where((labels > 0)[..., None], 0.6 * picture + 0.4 * ground, picture)
    return np.where(borders(rendered)[..., None], 20, ground).astype(np.uint8)


Layers = tuple[np.ndarray, np.ndarray, np.ndarray | None]


def overlays(shown: Sequence[Layers], scales: np.ndarray, longest: int) -> list[np.ndarray]:
    """The `overlay` of the layers of several images, cut to the animal, all of one size and at one scale.

    `scales` (k,) are those of the images in pixels a unit of the world; the longest side takes `longest` pixels.
    """
    boxes = [_box((labels > 0) | (rendered > 0)) for labels, rendered, _ in shown]
    most = max(max(side.stop - side.start for side in box) / s for box, s in zip(boxes, scales, strict=True))
    drawn = []
    for (labels, rendered, picture), box, scale in zip(shown, boxes, scales, strict=True):
        factor = longest / (most * scale)
        ground = None if picture is None else _enlarged(picture[box], factor)
        drawn.append(overlay(_enlarged(labels[box], factor), _enlarged(rendered[box], factor), ground))
    height, width = (max(picture.shape[axis] for picture in drawn) for axis in (0, 1))
    return [_centred(picture, height, width, PAPER) for picture in drawn]


def _box(mask: np.ndarray) -> tuple[slice, slice]:
    """The box around a mask with some pixels to spare; that of the image where the mask is empty."""
    found = np.nonzero(mask) if mask.any() else np.nonzero(~mask)
    rows, columns = (
        slice(max(int(at.min()) - SPARE, 0), min(int(at.max()) + SPARE + 1, count))
        for at, count in zip(found, mask.shape, strict=True)
    )
    return rows, columns


def _enlarged(layer: np.ndarray, factor: float) -> np.ndarray:
    """A picture (h, w, 3), or labels (h, w), enlarged or shrunk by a factor; labels stay labels."""
    import cv2

    size = [max(1, round(factor * count)) for count in layer.shape[1::-1]]
    return cv2.resize(layer, size, interpolation=cv2.INTER_NEAREST if layer.ndim == 2 else cv2.INTER_AREA)


def borders(labels: np.ndarray) -> np.ndarray:
    """Pixels (h, w) bool beside another label."""
    edge = np.zeros(labels.shape, bool)
    edge[:, 1:] |= labels[:, 1:] != labels[:, :-1]
    edge[1:] |= labels[1:] != labels[:-1]
    return edge


def legend(names: Sequence[str]) -> list[tuple[str, str]]:
    """Name and CSS colour of each part."""
    return [(name, "#" + bytes(int(v) for v in colours_of(k)).hex()) for k, name in enumerate(names)]


def two_heights(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Heights (h, w) of two surfaces in one picture (h, w, 3) uint8: red and blue, grey where they agree."""
    one, two = (255 * np.clip(heights / max(first.max(), 1e-9), 0, 1) for heights in (first, second))
    return np.stack([one, np.minimum(one, two), two], axis=-1).astype(np.uint8)
