"""Photographs of one object with its mask, and true shapes to judge by: height maps and normal maps of known
conventions.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import images, npz

CONVENTIONS = {"opengl": (1, 1, 1), "opencv": (1, -1, -1), "directx": (1, -1, 1)}
LARGEST = 1 << 26  # pixels
MOST_GREY = 0.1  # share of a mask between black and white: more than soft edges have
MARGIN = 0.1  # of the brightest, within which a value counts as black or as white
HALF = 0.5


@dataclass(frozen=True, eq=False)
class Photograph:
    """A picture in linear light with its mask."""

    colour: np.ndarray  # (h, w, 3) float64 in [0, 1]
    shown: np.ndarray  # (h, w, 3) uint8, for the eye
    mask: np.ndarray  # (h, w) bool
    saturated: float  # share of the object's pixels with a channel at the top of its range


def read(path: Path, mask_path: Path, response: str) -> Photograph:
    """Picture and mask. `response`: "srgb" undoes the gamma of ordinary pictures, "linear" takes the numbers as they
    are.

    Raises FormatError for pictures that are not of 8 or 16 bits, a mask of another size, an empty or full one, or one
    that is in several pieces of some size.
    """
    stored = images.read_stored(path)
    if stored.dtype not in (np.uint8, np.uint16):
        raise FormatError(path, "not a photograph", expected="8 or 16 bits a channel", got=stored.dtype)
    colour = _rgb(stored)
    top = np.iinfo(stored.dtype).max
    mask = read_mask(mask_path, colour.shape[:2])
    share = colour / top
    linear = _from_srgb(share) if response == "srgb" else share
    shown = np.rint(255 * (share if response == "srgb" else _to_srgb(share))).astype(np.uint8)
    saturated = float((colour[mask] >= top).any(axis=-1).mean())
    return Photograph(linear, shown, mask, saturated)


def _rgb(stored: np.ndarray) -> np.ndarray:
    if stored.ndim == 2:
        return np.repeat(stored[..., None], 3, axis=-1)
    return stored[..., 2::-1] if stored.shape[2] >= 3 else np.repeat(stored[..., :1], 3, axis=-1)


def _from_srgb(v: np.ndarray) -> np.ndarray:
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def _to_srgb(v: np.ndarray) -> np.ndarray:
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-12) ** (1 / 2.4) - 0.055)


def read_mask(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """A mask (h, w) bool: bright, or opaque where there is an alpha channel that is not full."""
    from scipy.ndimage import binary_fill_holes, label

    stored = images.read_stored(path)
    if stored.shape[:2] != tuple(shape):
        raise FormatError(
            path,
            "mask and picture differ in size",
            expected=f"{shape[1]} x {shape[0]}",
            got=f"{stored.shape[1]} x {stored.shape[0]}",
            fix="Give the --mask of this picture",
        )
    if not np.isfinite(stored).all():
        raise FormatError(path, "a mask of values that are not finite", fix="Paint the object white on black")
    plane = stored if stored.ndim == 2 else stored[..., 3] if _has_alpha(stored) else stored[..., :3].max(axis=-1)
    brightest = max(int(plane.max()), 1)
    mask = plane > HALF * brightest
    fix = "Paint the object white on black, in one piece"
    grey = float(((plane > MARGIN * brightest) & (plane < (1 - MARGIN) * brightest)).mean())
    if grey > MOST_GREY:
        raise FormatError(
            path, f"a picture of greys, not a mask: {100 * grey:.0f} % is neither black nor white", fix=fix
        )
    if not mask.any() or mask.all():
        raise FormatError(path, f"mask is {'empty' if not mask.any() else 'all object'}", fix=fix)
    parts, count = label(mask)
    sizes = np.bincount(parts.ravel())[1:]
    if count > 1 and np.sort(sizes)[-2] > 0.02 * sizes.max():
        raise FormatError(path, "mask is in several pieces", expected=1, got=count, fix=fix)
    mask = parts == 1 + int(sizes.argmax())
    holes = binary_fill_holes(mask) & ~mask
    inner, number = label(holes)
    small = np.flatnonzero(np.bincount(inner.ravel())[1:] < 1e-3 * mask.sum()) + 1  # specks, not windows
    return mask | np.isin(inner, small) if number else mask


def _has_alpha(stored: np.ndarray) -> bool:
    return stored.shape[2] == 4 and bool((stored[..., 3] < stored[..., 3].max()).any())


def read_normals(path: Path, convention: str, shape: tuple[int, int]) -> np.ndarray:
    """Unit normals (h, w, 3), x right, y up, z to the viewer, of a PNG, NPY or NPZ; NaN where they are zero or not
    known.

    Raises FormatError when most are not of unit length or face away: the sign of a wrong convention.
    """
    stored = _numbers(path)
    if stored.shape != (*shape, 3):
        raise FormatError(path, "normals and picture differ in size", expected=(*shape, 3), got=stored.shape)
    if stored.dtype.kind == "u":
        nothing = (stored == 0).all(axis=-1, keepdims=True)  # black stands for no normal
        stored = 2 * (stored[..., ::-1] / np.iinfo(stored.dtype).max) - 1
        stored = np.where(nothing, np.nan, stored)
    n = stored.astype(np.float64) * CONVENTIONS[convention]
    length = np.linalg.norm(n, axis=-1)
    known = np.isfinite(length) & (length > HALF)
    if not known.any() or np.median(np.abs(length[known] - 1)) > 0.05:
        raise FormatError(
            path, "normals are not of unit length", fix="Give (n + 1) / 2 as colours, or plain unit vectors as NPY"
        )
    if n[known][:, 2].mean() < 0:
        raise FormatError(
            path, f"normals face away from the viewer in the convention '{convention}'", fix="Give another --convention"
        )
    n[~known] = np.nan
    n[known] /= length[known, None]
    return n


def read_height(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """Heights (h, w) towards the viewer in pixels, NaN unknown, of an NPY or NPZ of one array."""
    stored = _numbers(path)
    if stored.shape != tuple(shape) or stored.dtype.kind != "f":
        got = f"{stored.dtype} {stored.shape}"
        raise FormatError(path, "not a height map of this picture", expected=f"floats of shape {tuple(shape)}", got=got)
    return stored.astype(np.float64)


def _numbers(path: Path) -> np.ndarray:
    path = Path(path)
    if path.suffix.lower() == ".npy":
        return images.read_npy(path)
    if path.suffix.lower() == ".npz":
        arrays = npz.read(path)
        if len(arrays) != 1:
            raise FormatError(path, "not one map", expected="a single array", got=f"{len(arrays)}: {', '.join(arrays)}")
        return next(iter(arrays.values()))
    if path.suffix.lower() != ".png":
        raise FormatError(path, "not a map that is read", expected=".npy, .npz or .png", got=path.suffix or "no suffix")
    return images.read_stored(path)


def encode_normals(normals: np.ndarray, convention: str) -> np.ndarray:
    """Normals (h, w, 3) as 16-bit colours (n + 1) / 2 in a convention; 0 where NaN."""
    n = normals * CONVENTIONS[convention]
    return np.where(np.isfinite(n), np.rint((np.nan_to_num(n) + 1) / 2 * 65535), 0).astype(np.uint16)
