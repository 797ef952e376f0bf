"""Maps of numbers as pictures: scales with a palette and limits, and the PNG bytes of arrays drawn on them.

Maps are written as PNG with a palette of 256 colours, one byte a pixel: a third of the size of an RGB picture of the
same colours, and faster to compress. Pixels without data keep two palette entries of their own, a grey and the
lines that hatch it.
"""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ipcli.report.kit.numbers import finite, log_ticks, round_outwards, ticks

WIDEST = 900  # pixels: no picture is stored wider
MISSING, HATCH = (150, 151, 156), (128, 129, 135)  # RGB: neutral on a light and on a dark page, in no palette below
RESERVED = 2  # palette entries 0 and 1 are MISSING and HATCH
LEVELS = 256 - RESERVED
OPENCV = {"turbo": "COLORMAP_TURBO", "viridis": "COLORMAP_VIRIDIS", "magma": "COLORMAP_MAGMA"}
ANCHORS = {  # palettes that OpenCV has not, linear between these
    "signed": ("053061", "2166ac", "92c5de", "f7f7f7", "f4a582", "b2182b", "67001f"),  # ColorBrewer RdBu, reversed
    "sea": ("081d58", "225ea8", "41b6c4", "a1dab4", "d9f0a3"),  # after ColorBrewer YlGnBu, reversed
    "clay": ("1d1a24", "4a4150", "8a7672", "c9ad98", "efe0cd", "fffaf0"),
}


@dataclass(frozen=True)
class Picture:
    """An encoded picture and its size in pixels."""

    data: bytes
    width: int
    height: int
    media: str = "image/png"

    @property
    def uri(self) -> str:
        return f"data:{self.media};base64,{b64encode(self.data).decode('ascii')}"


@dataclass(frozen=True)
class Scale:
    """How numbers become colours: ``low`` to ``high`` over a palette, linearly or by the logarithm; clipped beyond."""

    low: float
    high: float
    palette: str
    unit: str = ""
    log: bool = False
    whole: bool = False  # the values are counts: no fractions on the colour bar

    def position(self, values: np.ndarray | float) -> np.ndarray:
        """Where values lie on the bar: 0 at ``low``, 1 at ``high``, clipped; NaN stays, as do values <= 0 if log."""
        values = np.asarray(values)
        low, high = self.low, self.high
        with np.errstate(invalid="ignore", divide="ignore"):
            if self.log:
                values, low, high = np.log(np.where(values > 0, values, np.nan)), np.log(low), np.log(high)
            return np.clip((values - low) * (1 / (high - low)), 0, 1)

    def indices(self, values: np.ndarray) -> np.ndarray:
        """Palette entries (h, w) uint8 of a map (h, w); what is not finite is hatched."""
        position = self.position(values)
        known = np.isfinite(values) & ~np.isnan(position)
        with np.errstate(invalid="ignore"):
            return np.where(known, position * (LEVELS - 1) + (RESERVED + 0.5), _hatching(*position.shape)).astype(
                np.uint8
            )

    def ticks(self) -> list[float]:
        """Values to label on the colour bar: both limits, and round ones between them that leave the limits room."""
        inner = log_ticks(self.low, self.high, 4) if self.log else ticks(self.low, self.high, 4)
        clear = (value for value in inner if 0.14 < self.position(value) < 0.86)
        return [self.low, *(value for value in clear if not self.whole or value == int(value)), self.high]


def robust(arrays: Sequence[np.ndarray], palette: str, unit: str = "", *, log: bool = False) -> Scale:
    """The scale from the 1st to the 99th percentile of the finite values of maps, rounded outwards; 0 to 1 for none.

    A logarithmic scale looks at the positive values only.
    """
    values = finite(arrays)
    values = values[values > 0] if log else values
    if not values.size:
        return Scale(0.0, 1.0, palette, unit)
    low, high = (float(limit) for limit in np.percentile(values, (1, 99)))
    if log and high > 1.2 * low:
        return Scale(float(f"{low:.2g}"), float(f"{high:.2g}"), palette, unit, log=True)
    margin = max(abs(low), 1e-6) * 1e-3 if high - low <= 1e-6 * abs(high) else 0.0  # a constant map still needs a range
    return Scale(*round_outwards(low - margin, high + margin), palette, unit)


def from_zero(arrays: Sequence[np.ndarray], palette: str, unit: str = "") -> Scale:
    """The scale from 0 to the 99th percentile of some maps of magnitudes, rounded outwards."""
    values = np.abs(finite(arrays))
    top = float(np.percentile(values, 99) or values.max()) if values.size else 0.0
    return Scale(0.0, round_outwards(0.0, top)[1] if top else 1.0, palette, unit)


def symmetric(arrays: Sequence[np.ndarray], unit: str = "") -> Scale:
    """The scale of signed differences: white at 0, to both sides the 99th percentile of their magnitude."""
    high = from_zero(arrays, "signed").high
    return Scale(-high, high, "signed", unit)


def draw(values: np.ndarray, scale: Scale, widest: int = WIDEST) -> Picture:
    """A map (h, w) on a scale as a PNG, at most ``widest`` pixels wide; pixels without data are hatched grey."""
    return _png(scale.indices(thin(values, widest)), palette(scale.palette))


def strip(scale: Scale) -> Picture:
    """The palette from left to right, one pixel a colour: stretched by the page, it is the colour bar."""
    return _png(np.arange(RESERVED, 256, dtype=np.uint8)[None], palette(scale.palette))


def photograph(rgb: np.ndarray, widest: int = WIDEST) -> Picture:
    """An RGB image (h, w, 3) uint8 as a JPEG at most ``widest`` wide, averaged: nobody measures in it."""
    import cv2

    height, width = rgb.shape[:2]
    if width > widest:
        rgb = cv2.resize(rgb, (widest, max(1, round(height * widest / width))), interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, 86])
    return Picture(data.tobytes(), rgb.shape[1], rgb.shape[0], "image/jpeg")


def thin(array: np.ndarray, widest: int) -> np.ndarray:
    """Every n-th pixel, at most ``widest`` in a row: averages would hide the noise that a reader comes to see."""
    height, width = array.shape[:2]
    if width <= widest:
        return array
    rows, columns = (_centres(length, max(1, round(length * widest / width))) for length in (height, width))
    return array[rows[:, None], columns]


def _centres(length: int, wanted: int) -> np.ndarray:
    return ((np.arange(wanted) + 0.5) * (length / wanted)).astype(int)


@cache
def palette(name: str) -> np.ndarray:
    """The 256 RGB colours (256, 3) uint8 of a palette, the two of missing data first."""
    if name in ANCHORS:
        anchors = np.array([list(bytes.fromhex(colour)) for colour in ANCHORS[name]], dtype=float)
        at = np.linspace(0, len(anchors) - 1, LEVELS)
        colours = np.stack([np.interp(at, np.arange(len(anchors)), channel) for channel in anchors.T], axis=1).round()
    else:
        import cv2

        grey = np.linspace(0, 255, LEVELS).round().astype(np.uint8)
        colours = cv2.applyColorMap(grey[:, None], getattr(cv2, OPENCV[name]))[:, 0, ::-1]
    return np.vstack([MISSING, HATCH, colours]).astype(np.uint8)


def _hatching(height: int, width: int) -> np.ndarray:
    """Palette entries of missing data: one pixel in six of each row is hatched, along diagonals."""
    row = (np.arange(height + width) % 6 == 0).astype(np.uint8)
    return np.lib.stride_tricks.sliding_window_view(row, width)[:height]


def _png(indices: np.ndarray, colours: np.ndarray) -> Picture:
    """A PNG with a palette (colour type 3), rows unfiltered, as the standard advises for indexed colours."""
    height, width = indices.shape
    rows = np.zeros((height, width + 1), dtype=np.uint8)  # each row starts with the number of its filter: 0
    rows[:, 1:] = indices
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 2)
    chunks = _chunk(b"IHDR", header) + _chunk(b"PLTE", colours.tobytes()) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")
    return Picture(b"\x89PNG\r\n\x1a\n" + chunks, width, height)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
