"""Reliefs as moving pictures without a script: lit by a lamp that goes round, and turned from side to side.

A moving picture is one tall JPEG of frames that a style sheet steps through; it stands still when printed.
"""

from __future__ import annotations

import numpy as np

from ipcli.report.kit.page import Markup, element
from ipcli.report.kit.pictures import Picture, palette, photograph, thin

FRAMES = 20
WIDEST = 320  # pixels of a frame
LAMP = 0.9  # radians from the line of sight
SWING = 50.0  # degrees to each side
GROUND = (36, 38, 43)
STYLE = Markup(
    ".film{overflow:hidden;position:relative;border-radius:3px}.film "
    "img{position:absolute;left:0;top:0;width:100%;height:auto}"
    "@media(prefers-reduced-motion:no-preference){.film img{animation:film 5s steps(var(--frames)) infinite}}"
    "@keyframes film{to{transform:translateY(-100%)}}"
)


def style() -> Markup:
    """The style sheet of moving pictures, once a page."""
    return element("style", STYLE)


def film(frames: list[np.ndarray], caption: object, note: object = "") -> Markup:
    """Frames (h, w, 3) uint8 of one size as a figure that plays."""
    picture: Picture = photograph(np.concatenate(frames), widest=10_000)
    h, w = frames[0].shape[:2]
    shown = element("img", src=picture.uri, alt=f"{caption}: {len(frames)} frames", style=f"--frames:{len(frames)}")
    box = element("div", shown, class_="film", style=f"aspect-ratio:{w}/{h}")
    return element("figure", box, element("figcaption", element("b", caption), element("span", note) if note else ""))


def lit(normals: np.ndarray, towards: np.ndarray, shine: float = 0.35) -> np.ndarray:
    """Clay (h, w, 3) uint8 under a lamp in a direction, with a soft highlight; the ground where there is no normal."""
    known = np.isfinite(normals).all(axis=-1)
    n = np.nan_to_num(normals)
    half = towards + np.array([0, 0, 1.0])
    half = half / np.linalg.norm(half)
    light = 0.08 + 0.72 * np.clip(n @ towards, 0, 1) + shine * np.clip(n @ half, 0, 1) ** 24
    clay = palette("clay")[2:][np.rint(np.clip(light, 0, 1) * 253).astype(int)]
    return np.where(known[..., None], clay, GROUND).astype(np.uint8)


def going_round(normals: np.ndarray) -> list[np.ndarray]:
    """The relief (h, w, 3) under a lamp that goes round the line of sight."""
    small = thin(normals, WIDEST)
    angles = np.arange(FRAMES) * 2 * np.pi / FRAMES
    lamps = [np.array([np.cos(a) * np.sin(LAMP), np.sin(a) * np.sin(LAMP), np.cos(LAMP)]) for a in angles]
    return [lit(small, lamp) for lamp in lamps]


def swinging(height: np.ndarray, normals: np.ndarray, colours: np.ndarray | None = None) -> list[np.ndarray]:
    """The relief turned about the vertical, to the right, back and to the left."""
    angles = SWING * np.sin(np.arange(FRAMES) * 2 * np.pi / FRAMES)
    return [seen(height, normals, float(angle), colours) for angle in angles]


def seen(
    height: np.ndarray, normals: np.ndarray, yaw: float, colours: np.ndarray | None = None, pitch: float = 12.0
) -> np.ndarray:
    """The relief (h, w) from a viewpoint turned by degrees, orthographic: points through a z-buffer, lit from the
    upper left.
    """
    small, n = thin(height, WIDEST), thin(normals, WIDEST)
    scale = small.shape[1] / height.shape[1]
    lamp = np.array([-0.45, 0.55, 0.7]) / np.linalg.norm([-0.45, 0.55, 0.7])
    paint = lit(n, lamp) if colours is None else thin(colours, WIDEST)
    known = np.isfinite(small)
    rows, columns = np.nonzero(known)
    points = np.stack([columns - columns.mean(), rows.mean() - rows, scale * small[known]], axis=-1)
    points[:, 2] -= np.median(points[:, 2])
    turned = points @ _turn(yaw, pitch).T
    side = int(1.15 * max(np.ptp(rows), np.ptp(columns))) + 8
    return _splat(turned, paint[known], side)


def _turn(yaw: float, pitch: float) -> np.ndarray:
    a, b = np.radians(yaw), np.radians(pitch)
    about_y = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return about_x @ about_y


def _splat(points: np.ndarray, paint: np.ndarray, side: int) -> np.ndarray:
    """The nearest point of each pixel and of its right and lower neighbours, so that a turned surface has no holes."""
    order = np.argsort(points[:, 2], kind="stable")
    x = np.rint(points[order, 0] + side / 2).astype(int)
    y = np.rint(side / 2 - points[order, 1]).astype(int)
    canvas = np.full((side, side, 3), GROUND, np.uint8)
    depth = np.full((side, side), -np.inf)
    for dx, dy in ((1, 1), (0, 1), (1, 0), (0, 0)):
        u, v = np.clip(x + dx, 0, side - 1), np.clip(y + dy, 0, side - 1)
        nearest = np.full((side, side), -np.inf)
        nearest[v, u] = points[order, 2]  # the last one written stays: the nearest
        colour = canvas.copy()
        colour[v, u] = paint[order]
        before = nearest > depth + (0 if (dx, dy) == (0, 0) else 1.0)
        canvas[before], depth[before] = colour[before], nearest[before]
    return canvas


def as_colours(normals: np.ndarray) -> np.ndarray:
    """Normals as the colours (n + 1) / 2, (h, w, 3) uint8; the ground where there is none."""
    known = np.isfinite(normals).all(axis=-1)
    return np.where(known[..., None], np.rint(127.5 * (np.nan_to_num(normals) + 1)), GROUND).astype(np.uint8)


def ball(chart: np.ndarray, size: int = 200) -> np.ndarray:
    """A ball of the material under the light of a chart (s, s) or (s, s, 3), as (size, size, 3) uint8 for the eye."""
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    inside = np.hypot(x, y) < 1
    at = np.rint((np.stack([x, y]) + 1) / 2 * (len(chart) - 1)).astype(int)
    table = chart if chart.ndim == 3 else np.repeat(chart[..., None], 3, axis=-1)
    light = table[at[0], at[1]]
    light = light / max(float(np.percentile(light[inside], 99)), 1e-9)
    return np.where(inside[..., None], np.rint(255 * np.clip(light, 0, 1) ** (1 / 2.2)), GROUND).astype(np.uint8)
