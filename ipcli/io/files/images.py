"""Depth maps and colour images. Depth is read from 16-bit PNG and TIFF, float TIFF, PFM, NPY and NPZ.

Stored value = scale * depth: 5000 for TUM, 1000 for millimetres read as metres, 256 for KITTI disparities. The decoders
behind OpenCV return the upper part of a cut PNG or JPEG without a word, so both are checked before they are decoded.
"""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np

from ipcli import memory
from ipcli.errors import FormatError, IpcliError
from ipcli.inputs import check_file
from ipcli.io.files import atomic, exr, npz
from ipcli.io.files.picture_size import declared_size

PNG = b"\x89PNG\r\n\x1a\n"
JPEG, JPEG_SCAN, JPEG_END = b"\xff\xd8\xff", b"\xff\xda", b"\xff\xd9"
SATURATED = 65535
DEPTH_SUFFIXES = (".png", ".pfm", ".tif", ".tiff", ".npy", ".npz", ".exr")
BYTES_A_PIXEL = 8  # of a decoded image, at the most: 4 channels of 16 bits
FAR, FAR_PIXELS = 1000.0, 10  # of the median of the rest, and so many pixels alike: a background without a surface


def read_depth(
    path: Path, scale: float | None = None, missing_value: float | None = None, what: str = "depth"
) -> np.ndarray:
    """Depth (h, w) float32 in the unit of the scene, NaN where missing.

    Missing are a stored 0, NaN or infinity, 65535 of 16 bits, `missing_value`, and in floats the value that renderers
    write where no surface is (see `far_plane`). Integers need `scale`; floats are taken as they are when it is None.
    FormatError for an unreadable file, an unknown scale, or negative values, with the count and the first pixel, which
    are called `what`.
    """
    stored = _stored(Path(path))
    if stored.ndim != 2 or not stored.size:
        raise FormatError(path, "not one depth map", expected="shape (h, w)", got=stored.shape)
    missing = stored == 0
    if missing_value is not None:
        missing |= stored == missing_value
    if stored.dtype.kind in "iu" and stored.dtype.itemsize > 1:
        if scale is None:
            bits = 8 * stored.dtype.itemsize
            raise FormatError(
                path, f"{bits}-bit {what} of unknown scale", fix="Give the depth scale: stored value = scale * depth"
            )
        if stored.dtype == np.uint16:
            missing |= stored == SATURATED
    elif stored.dtype.kind == "f":
        missing |= np.isnan(stored) | (stored == np.inf)
        missing |= stored == far_plane(stored[~missing])
    else:
        known = "floats, or integers of 16 bits or more"
        raise FormatError(path, f"wrong type of {what}", expected=known, got=stored.dtype)
    fix = "Say which value means no data with --missing, or mark it as NaN" if what == "depth" else "Give values >= 0"
    _refuse(path, stored, f"negative {what}", ~missing & (stored < 0), fix)
    with np.errstate(over="ignore", under="ignore"):
        depth = np.where(missing, np.nan, stored.astype(np.float64) / (scale or 1.0)).astype(np.float32)
    bad = ~missing & ~((depth > 0) & np.isfinite(depth))
    _refuse(path, stored, f"{what} that 32-bit floats cannot hold", bad, "Mark missing values as NaN")
    return depth


def far_plane(known: np.ndarray) -> float:
    """The value that stands for "no surface" in known values (n,), NaN if none does: renderers write 1e10, 65504, ...

    It is the largest, many pixels have exactly it, and it is far beyond all others.
    """
    largest = known.max() if known.size else 0.0
    rest = known[known < largest]
    if rest.size < 10 * FAR_PIXELS:
        return float("nan")
    alone = known.size - rest.size >= FAR_PIXELS and largest > FAR * np.median(np.abs(rest))
    return float(largest) if alone and largest > FAR / 10 * rest.max() else float("nan")


def _refuse(path: Path, stored: np.ndarray, what: str, bad: np.ndarray, fix: str) -> None:
    if bad.any():
        row, column = (int(index) for index in np.argwhere(bad)[0])
        first = f"{int(bad.sum())} pixels, the first {stored[row, column]} at row {row}, column {column}"
        raise FormatError(path, what, expected="values > 0, 0 or NaN where missing", got=first, fix=fix)


def _stored(path: Path) -> np.ndarray:
    """The numbers of a depth file before any meaning is given to them."""
    suffix = path.suffix.lower()
    if suffix == ".npz":
        arrays = npz.read(path)
        if len(arrays) != 1:
            raise FormatError(
                path, "not one depth map", expected="a single array", got=f"{len(arrays)}: {', '.join(arrays)}"
            )
        return next(iter(arrays.values()))
    data = _bytes(path)
    if suffix == ".npy":
        return _npy(path, data)
    if suffix == ".pfm":
        return _pfm(path, data)
    if suffix == ".exr":
        return exr.decode(path, data)
    if suffix in DEPTH_SUFFIXES:
        return decoded(path, data, as_colour=False)
    raise FormatError(path, "not a depth file", expected=" ".join(DEPTH_SUFFIXES), got=suffix or "no suffix")


def _bytes(path: Path) -> bytes:
    check_file(path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}") from error


def read_npy(path: Path) -> np.ndarray:
    """The array of an NPY file, nothing pickled. FormatError otherwise."""
    return _npy(Path(path), _bytes(Path(path)))


def _npy(path: Path, data: bytes) -> np.ndarray:
    import io

    stream = io.BytesIO(data)
    try:
        array = np.lib.format.read_array(stream, allow_pickle=False)
    except npz.UNREADABLE as error:
        raise FormatError(path, f"not a readable NPY file: {error}") from error
    if stream.tell() != len(data):
        raise FormatError(path, "bytes after the end of the array", expected=stream.tell(), got=len(data))
    return array


def _pfm(path: Path, data: bytes) -> np.ndarray:
    """One channel of floats, bottom row first; the sign of the third line tells the byte order."""
    try:
        magic, size, order, pixels = data.split(b"\n", 3)
        columns, rows = (int(word) for word in size.split())
        code = "<f4" if float(order) < 0 else ">f4"
    except ValueError as error:
        raise FormatError(path, "not a readable PFM file: the header is cut or wrong") from error
    if magic.strip() != b"Pf" or columns < 1 or rows < 1 or len(pixels) != 4 * rows * columns:
        got = f"{magic[:8].decode('latin-1')} {columns}x{rows} with {len(pixels)} bytes"
        raise FormatError(path, "not a whole one-channel PFM", expected="Pf with 4 bytes a pixel", got=got)
    return np.flipud(np.frombuffer(pixels, code).reshape(rows, columns)).astype(np.float32)


def read_image(path: Path) -> np.ndarray:
    """Colours (h, w, 3) uint8 RGB of any image OpenCV reads; grey is repeated, alpha dropped. FormatError otherwise."""
    path = Path(path)
    return decoded(path, _bytes(path), as_colour=True)


def read_stored(path: Path) -> np.ndarray:
    """The numbers (h, w) or (h, w, c) of any image OpenCV reads as they are stored, channels in OpenCV's order.
    FormatError otherwise.
    """
    path = Path(path)
    return decoded(path, _bytes(path), as_colour=False)


def decoded(path: Path, data: bytes, as_colour: bool) -> np.ndarray:
    """The pixels of the bytes of an image file, RGB (h, w, 3) uint8 or as they are stored; FormatError names `path`."""
    import cv2

    if (data.startswith(PNG) and not _whole_png(data)) or (data.startswith(JPEG) and not _whole_jpeg(data)):
        raise FormatError(path, "truncated or damaged image", fix="Copy it again")
    if size := declared_size(data):
        memory.check(path, BYTES_A_PIXEL * size[0] * size[1], f"{size[0]} x {size[1]} pixels")
    level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # else it prints what we raise
    try:
        # of a JPEG, UNCHANGED would keep nothing more but forget the turn that EXIF asks for, as no viewer does
        upright = cv2.IMREAD_ANYCOLOR if data.startswith(JPEG) else cv2.IMREAD_UNCHANGED
        flags = cv2.IMREAD_COLOR if as_colour else upright
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error as error:
        raise FormatError(path, f"not a readable image: {' '.join(error.err.split())}") from error
    finally:
        cv2.utils.logging.setLogLevel(level)
    if image is None:
        raise FormatError(path, "not a readable image" if data else "empty file", fix="Copy it again")
    return np.ascontiguousarray(image[..., ::-1]) if as_colour else image


def _whole_png(data: bytes) -> bool:
    """Whether all chunks up to IEND are there with right checksums."""
    offset = len(PNG)
    while offset + 12 <= len(data):
        length = int.from_bytes(data[offset : offset + 4])
        body, checksum = data[offset + 4 : offset + 8 + length], data[offset + 8 + length : offset + 12 + length]
        if len(checksum) < 4 or zlib.crc32(body) != int.from_bytes(checksum):
            return False
        if body[:4] == b"IEND":
            return True
        offset += 12 + length
    return False


def _whole_jpeg(data: bytes) -> bool:
    """Whether the last scan is ended; an embedded preview ends before the scan of the picture begins."""
    return data.rfind(JPEG_END) > data.rfind(JPEG_SCAN)


def encode_png(array: np.ndarray) -> bytes:
    """PNG of (h, w) grey or (h, w, 3) RGB, uint8 or uint16; the same bytes for the same array."""
    import cv2

    array = np.asarray(array)
    if array.dtype not in (np.uint8, np.uint16) or not (array.ndim == 2 or array.shape[2:] == (3,)) or not array.size:
        raise IpcliError(
            f"PNG: expected (h, w) or (h, w, 3) of uint8 or uint16, got {array.dtype} of shape {array.shape}"
        )
    done, data = cv2.imencode(".png", array if array.ndim == 2 else np.ascontiguousarray(array[..., ::-1]))
    if not done:
        raise IpcliError(f"PNG: the encoder refused an image of shape {array.shape}")
    return data.tobytes()


def write_png(path: Path, array: np.ndarray) -> None:
    """Write `encode_png(array)` atomically."""
    atomic.write_bytes(path, encode_png(array))


def write_depth_png16(path: Path, depth: np.ndarray, scale: float) -> None:
    """Write depth (h, w) as rounded scale * depth, 0 where NaN.

    FormatError when a depth would not fit: above 65534, since 65535 means missing, or so small that it would be rounded
    to 0.
    """
    with np.errstate(over="ignore"):
        stored = np.rint(np.asarray(depth, np.float64) * scale)
    known = ~np.isnan(stored)
    outside = known & ~((stored >= 1) & (stored < SATURATED))
    if outside.any():
        got = f"{np.nanmin(stored):g} to {np.nanmax(stored):g}, {int(outside.sum())} pixels outside"
        raise FormatError(
            path, "depth does not fit 16 bits", expected=f"1 to {SATURATED - 1}", got=got, fix="Choose another scale"
        )
    write_png(path, np.where(known, stored, 0).astype(np.uint16))
