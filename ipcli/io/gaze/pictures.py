"""Frames from pairs of picture files, and what all recordings in folders share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import text as layout
from ipcli.io.files.images import read_image
from ipcli.measurements.recording import Camera, Frame

GREY = np.array([0.299, 0.587, 0.114])


def grey(image: np.ndarray) -> np.ndarray:
    """(h, w) uint8 of a picture (h, w, 3)."""
    if (image[..., 0] == image[..., 1]).all() and (image[..., 0] == image[..., 2]).all():
        return np.ascontiguousarray(image[..., 0])
    return np.rint(image @ GREY).astype(np.uint8)


def loader(pairs: Sequence[tuple[Path, ...]], cameras: Sequence[Camera]) -> Callable[[int], Frame]:
    """How the frames of these files (left, or both) are read; FormatError for another size than calibrated."""

    def load(k: int) -> Frame:
        images = [read_image(path) for path in pairs[k]]
        for path, image, camera in zip(pairs[k], images, cameras, strict=False):
            check_size(path, image.shape[:2], camera)
        left = grey(images[0])
        coloured = not (images[0][..., 0] == left).all()
        right = grey(images[1]) if len(images) > 1 else None
        return Frame(left, right, colour=images[0] if coloured else None)

    return load


def check_size(path: Path, shape: tuple[int, ...], camera: Camera) -> None:
    """FormatError unless a picture (h, w) is of the size that the camera was calibrated for."""
    if (shape[1], shape[0]) != tuple(camera.size):
        raise FormatError(
            path,
            "picture is of another size than its calibration",
            expected=f"{camera.size[0]} x {camera.size[1]}",
            got=f"{shape[1]} x {shape[0]}",
            fix="Give the calibration of this resolution, or the pictures it was made for",
        )


def matched(folder: Path, left: dict[str, Path], right: dict[str, Path]) -> tuple[list[str], tuple[str, ...]]:
    """Names that both cameras have, in order, and words on those that only one has; FormatError when none pair up."""
    common = sorted(left.keys() & right.keys(), key=natural)
    if not common:
        raise FormatError(
            folder,
            "no picture of the left camera has one of the right",
            expected="equal names",
            got=f"{len(left)} left, {len(right)} right",
            fix="Name the pictures of one moment alike",
        )
    alone = sorted(left.keys() ^ right.keys(), key=natural)
    words = (f"{len(alone)} pictures have no partner, the first is {alone[0]}",) if alone else ()
    return common, words


def natural(name: str) -> tuple[int, str]:
    """Numbers by their value, so that 10 comes after 9."""
    digits = "".join(character for character in name if character.isascii() and character.isdigit())
    return (int(digits) if 0 < len(digits) < 40 else 0, name)


def size_of(path: Path) -> tuple[int, int]:
    """Width and height of a picture."""
    height, width = read_image(path).shape[:2]
    return width, height


def camera_of(path: Path, values: Sequence[float], size: tuple[int, int], **rest: object) -> Camera:
    """A camera of fx, fy, cx, cy, checked: positive focal lengths, principal point near the picture."""
    fx, fy, cx, cy = (float(value) for value in values)
    inside = -0.5 * size[0] <= cx <= 1.5 * size[0] and -0.5 * size[1] <= cy <= 1.5 * size[1]
    if not (fx > 0 and fy > 0 and inside):
        raise FormatError(
            path,
            "calibration makes no sense",
            expected="fx, fy > 0 and cx, cy near the picture, in pixels",
            got=f"{fx:g}, {fy:g}, {cx:g}, {cy:g} for {size[0]} x {size[1]}",
            fix="Give fx, fy, cx, cy in pixels",
        )
    return Camera(size, layout.camera_matrix([fx, fy, cx, cy]), **rest)  # type: ignore[arg-type]
