"""Maps laid over pictures, and fixations drawn into them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ipcli.report.kit.pictures import Scale, palette

DARKEST = 0.18  # of the light that a place keeps where nobody is likely to look
LEAST_BRIGHT = 2.0  # times chance that a place is looked at to be drawn bright: of a flat picture none is
DOT = (255, 45, 45)  # RGB of a fixation
RIM = (255, 255, 255)
TURNS = (0, 90, 180, 270)  # degrees about the vertical
PALETTE = "magma"  # of saliency
SIDE = 300  # pixels of a picture of a surface
BEHIND = 245


def items(arrays: Mapping[str, np.ndarray] | Iterable[str], collection: str) -> list[str]:
    """Names of the items of a collection, in order."""
    return sorted({name.split("/")[1] for name in arrays if name.startswith(f"{collection}/")})


def glow(picture: np.ndarray, saliency: np.ndarray) -> np.ndarray:
    """A picture (h, w, 3) uint8, dimmed where its map (a, b), in times chance, is low."""
    import cv2

    share = saliency.astype(np.float32) / max(float(np.percentile(saliency, 99)), LEAST_BRIGHT)
    light = cv2.resize(np.clip(share, 0, 1) ** 0.6, picture.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return (picture * (DARKEST + (1 - DARKEST) * light)[..., None]).astype(np.uint8)


def dotted(picture: np.ndarray, fixations: np.ndarray) -> np.ndarray:
    """A picture (h, w, 3) uint8 with fixations (n, 2), as shares of its sides, as red dots."""
    import cv2

    drawn = np.ascontiguousarray(picture.copy())
    radius = max(2, round(picture.shape[1] / 160))
    for x, y in fixations * np.array(picture.shape[1::-1]):
        cv2.circle(drawn, (int(x), int(y)), radius + 1, RIM, -1, cv2.LINE_AA)
        cv2.circle(drawn, (int(x), int(y)), radius, DOT, -1, cv2.LINE_AA)
    return drawn


def around(points: np.ndarray, normals: np.ndarray, values: np.ndarray, scale: Scale, turn: float) -> np.ndarray:
    """Points (n, 3) with y up in the colours of their values (n,), shaded, turned by degrees about the vertical, from
    afar: a picture (SIDE, SIDE, 3) uint8.
    """
    import cv2

    angle = np.radians(turn)
    rotation = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    centred = points - (points.max(axis=0) + points.min(axis=0)) / 2
    reach = max(float(np.linalg.norm(centred, axis=1).max()), 1e-12)
    seen, facing = centred @ rotation.T, (normals @ rotation.T)[:, 2]
    place = (SIDE / 2 + seen[:, :2] * np.array([1, -1]) / reach * SIDE * 0.48).astype(int)
    colours = palette(scale.palette)[scale.indices(values[None])[0]] * (0.45 + 0.55 * np.abs(facing))[:, None]
    radius = int(np.clip(SIDE * 0.9 / np.sqrt(len(points)), 1, 6))
    drawn = np.full((SIDE, SIDE, 3), BEHIND, np.uint8)
    for k in np.argsort(seen[:, 2], kind="stable"):
        if facing[k] > 0:
            cv2.circle(drawn, tuple(place[k].tolist()), radius, tuple(colours[k].tolist()), -1)
    return _closed(drawn)


def _closed(drawn: np.ndarray) -> np.ndarray:
    """The picture without the single pixels between points through which the background shows."""
    import cv2

    empty = (drawn == BEHIND).all(axis=2)
    covered = cv2.morphologyEx((~empty).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
    return np.where((covered & empty)[..., None], cv2.medianBlur(drawn, 3), drawn)
