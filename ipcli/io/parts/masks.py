"""Part masks of one image: an index PNG, a folder of one PNG a part, LabelMe JSON, or a .mat of PASCAL-Part.

Each reader returns the names of the parts it met and labels (h, w) int16: 0 background, k + 1 the k-th name.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import json_of
from ipcli.io.files import images
from ipcli.io.parts import pascal

MOST_PIXELS = 50_000_000  # of one image
MOST_PARTS = 250


class Masks(NamedTuple):
    """Names of the parts in an image and its labels (h, w) int16."""

    names: tuple[str, ...]
    labels: np.ndarray


def read(path: Path, names: Sequence[str] = (), which: int = 0) -> Masks:
    """The masks at `path`. `names` says what the values 1, 2, ... of an index PNG mean; `which` picks an object of a
    PASCAL-Part file. Raises FormatError for whatever is not such a file.
    """
    path = Path(path)
    if path.is_dir():
        return read_folder(path)
    readers = {".png": lambda: read_index(path, names), ".json": lambda: read_labelme(path)}
    readers[".mat"] = lambda: Masks(*pascal.read(path, which))
    if path.suffix.lower() not in readers:
        expected = "a .png of indices, a folder of .png, LabelMe .json or PASCAL-Part .mat"
        raise FormatError(path, "not part masks", expected=expected, got=path.suffix or "no suffix")
    return readers[path.suffix.lower()]()


def object_told(path: Path, which: int = 0) -> str:
    """Which of the objects of a PASCAL-Part file `which` is, in words; empty for other masks. Raises FormatError."""
    if path.suffix.lower() != ".mat":
        return ""
    classes = pascal.objects(path)
    others = f" (the file holds {pascal.counted(classes)}; object = NUMBER picks another)" if len(classes) > 1 else ""
    return f" of object {which}, a {classes[which]}{others}"


def read_index(path: Path, names: Sequence[str]) -> Masks:
    """A PNG, grey or with a palette, whose values are indices: 0 background, 1 the first of `names`.

    One in colour that is grey all over is read as grey; where there is but one name, whatever is not black has it.
    """
    values = _values(path)
    indices = _not_black(values) if len(names) == 1 else _grey(path, values)
    if indices.max(initial=0) > len(names):
        fix = "Add `labels` to this image in the project: the names of the values from 1 on"
        raise FormatError(
            path, "a value without a name", expected=f"0 to {len(names)}", got=int(indices.max()), fix=fix
        )
    return Masks(tuple(names), indices.astype(np.int16))


def read_folder(folder: Path) -> Masks:
    """One PNG a part, named after it; not black is the part. A pixel of two parts belongs to the later name."""
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".png" and path.is_file())
    if not files or len(files) > MOST_PARTS:
        raise FormatError(folder, "no folder of masks", expected=f"1 to {MOST_PARTS} .png files", got=len(files))
    labels = None
    for number, path in enumerate(files, start=1):
        mask = _not_black(_values(path)) > 0
        if labels is None:
            labels = np.zeros(mask.shape, np.int16)
        if mask.shape != labels.shape:
            raise FormatError(path, "another size than the first mask", expected=labels.shape, got=mask.shape)
        labels[mask] = number
    assert labels is not None
    return Masks(tuple(path.stem for path in files), labels)


def read_labelme(path: Path) -> Masks:
    """Polygons, rectangles and circles of a LabelMe file; what comes later lies on top."""
    try:
        content = json_of(path.read_text(encoding="utf-8"))
        shapes = [(str(shape["label"]), _polygon(shape)) for shape in content["shapes"]]
        size = (content["imageHeight"], content["imageWidth"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FormatError(path, f"not a LabelMe file ({type(error).__name__}: {error})") from error
    if not all(type(side) is int and side > 0 for side in size):
        raise FormatError(path, "no size of the image", expected="imageHeight and imageWidth, whole and > 0", got=size)
    _check_size(path, size)
    names = tuple(dict.fromkeys(label for label, _ in shapes))
    if not names or len(names) > MOST_PARTS:
        raise FormatError(path, "wrong number of labels", expected=f"1 to {MOST_PARTS}", got=len(names))
    return Masks(names, _drawn(size, names, shapes))


def _polygon(shape: dict) -> np.ndarray:
    points = np.array(shape["points"], np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all() or np.abs(points).max() > 1e6:
        raise ValueError(f"points of {shape.get('label')!r} are not pairs of coordinates")
    kind = shape.get("shape_type") or "polygon"
    if kind == "rectangle" and len(points) == 2:
        (a, b), (c, d) = points
        return np.array([[a, b], [c, b], [c, d], [a, d]])
    if kind == "circle" and len(points) == 2:
        turn = np.linspace(0, 2 * np.pi, 90, endpoint=False)
        return points[0] + np.linalg.norm(points[1] - points[0]) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if kind != "polygon" or len(points) < 3:
        raise ValueError(f"a {kind} of {len(points)} points; polygons, rectangles and circles are read")
    return points


def _drawn(size: tuple[int, int], names: Sequence[str], shapes: Sequence[tuple[str, np.ndarray]]) -> np.ndarray:
    import cv2

    canvas = np.zeros(size, np.uint8)
    for label, polygon in shapes:
        cv2.fillPoly(canvas, [np.rint(polygon).astype(np.int32)], names.index(label) + 1)
    return canvas.astype(np.int16)


def _values(path: Path) -> np.ndarray:
    """Values (h, w) int32 of a PNG, of a palette its indices; of colours (h, w, 3), black where transparent."""
    from PIL import Image

    data = images._bytes(path)
    if not data.startswith(images.PNG) or not images._whole_png(data):
        raise FormatError(path, "not a whole PNG", fix="Copy it again")
    try:
        with Image.open(path) as image:
            _check_size(path, image.size)
            values = np.asarray(image)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise FormatError(path, f"not a readable PNG: {error}") from error
    if values.shape[2:] in ((2,), (4,)):  # the last channel is alpha
        values = np.where(values[..., -1:] > 0, values[..., :-1], np.uint8(0))
    return values.astype(np.int32)


def _not_black(values: np.ndarray) -> np.ndarray:
    """1 (h, w) where colours are not black; values (h, w) as they are."""
    return np.asarray(values.any(axis=-1), np.int32) if values.ndim == 3 else values


def _grey(path: Path, values: np.ndarray) -> np.ndarray:
    """Values (h, w) of which all channels say the same. Raises FormatError for colours, which name no part."""
    if values.ndim == 2:
        return values
    grey = values[..., 0]
    if (values != grey[..., None]).any():
        colours = len(np.unique(values.reshape(-1, values.shape[2]), axis=0))
        raise FormatError(
            path, f"{colours} colours, which do not say what part each is", expected="indices 0, 1, 2, ...",
            fix="Save it as a grey or palette PNG of indices, or give a folder of one PNG a part",
        )  # fmt: skip
    return grey


def _check_size(path: Path, size: Sequence[int]) -> None:
    if size[0] * size[1] > MOST_PIXELS:
        raise FormatError(path, "too large", expected=f"at most {MOST_PIXELS} pixels", got=f"{size[0]} x {size[1]}")
