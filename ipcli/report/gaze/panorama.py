"""Points of regard on pictures: on single frames, and on a panorama around the middle of the path (figure 3.3)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.geometry import lens

WIDTH = 880  # pixels of the panorama
LOOK = (214, 58, 58)
NOW = (250, 214, 60)


def with_regards(a: Mapping[str, np.ndarray], n: int) -> np.ndarray:
    """The n-th picture kept, with the points of regard of its frame."""
    import cv2

    image = np.array(a["pictures"][n])  # a copy: the artefact is drawn from, never drawn into
    if "shown/frame" not in a:
        return image
    scale = image.shape[1] / a["rig/sizes"][0, 0]
    mine = np.flatnonzero(a["shown/frame"] == a["picture_frames"][n])
    for order, row in enumerate(mine[::-1]):  # the nearest in time comes first: drawn last
        u, v = (round(float(value) * scale) for value in a["shown/pixels"][row])
        cv2.circle(image, (u, v), 5, NOW if order == len(mine) - 1 else LOOK, 2, cv2.LINE_AA)
    return image


def panorama(a: Mapping[str, np.ndarray]) -> np.ndarray:
    """(h, w, 3) uint8: longitude over latitude, each pixel from the picture that sees it nearest to its middle."""
    import cv2

    known = [n for n, frame in enumerate(a["picture_frames"]) if not a["lost"][frame]]
    poses = a["world_from_rig"][a["picture_frames"][known]]
    if not known:
        return np.full((80, WIDTH, 3), 200, np.uint8)
    low, high = _span(a, poses)
    step = (high[0] - low[0]) / WIDTH
    height = int(np.clip((high[1] - low[1]) / step, 40, WIDTH))
    lon, lat = np.meshgrid(low[0] + step * (np.arange(WIDTH) + 0.5), low[1] + step * (np.arange(height) + 0.5))
    rays = np.stack([np.sin(lon) * np.cos(lat), np.sin(lat), np.cos(lon) * np.cos(lat)], axis=-1)
    canvas, best = np.full((height, WIDTH, 3), 225, np.uint8), np.full((height, WIDTH), 0.2)
    for n, pose in zip(known, poses, strict=True):
        image, seen = a["pictures"][n], rays @ pose[:3, :3]
        drawn = _pixels(a, seen) * (image.shape[1] / a["rig/sizes"][0, 0])
        inside = ((drawn >= 0) & (drawn <= np.array(image.shape[1::-1]) - 1)).all(axis=-1) & (seen[..., 2] > best)
        maps = np.nan_to_num(drawn, nan=-9).astype(np.float32)
        looked = cv2.remap(image, maps[..., 0].copy(), maps[..., 1].copy(), cv2.INTER_LINEAR)
        canvas[inside], best[inside] = looked[inside], seen[..., 2][inside]
    _mark(a, canvas, np.median(poses[:, :3, 3], axis=0), low, step)
    return canvas


def _span(a: Mapping[str, np.ndarray], poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest longitude and latitude that the pictures reach."""
    width, height = a["rig/sizes"][0]
    rim = np.array([[u, v] for u in (0, width / 2, width - 1) for v in (0, height / 2, height - 1)])
    k = a["rig/intrinsics"][0]
    flat = np.clip(lens.normalised_of(rim, k), -1.5, 1.5)
    rays = np.concatenate([flat, np.ones((len(rim), 1))], axis=1) @ np.swapaxes(poses[:, :3, :3], 1, 2)
    lon, lat = np.arctan2(rays[..., 0], rays[..., 2]), np.arctan2(rays[..., 1], np.hypot(rays[..., 0], rays[..., 2]))
    return np.array([lon.min(), lat.min()]), np.array([max(lon.max(), lon.min() + 0.2), lat.max()])


def _pixels(a: Mapping[str, np.ndarray], seen: np.ndarray) -> np.ndarray:
    """Pixels in camera 0's picture of directions in its frame; NaN behind."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ideal = seen[..., :2] / np.where(seen[..., 2:] > 0.1, seen[..., 2:], np.nan)
    row = a["rig/distortion"][0]
    drawn = lens.distort(str(a["rig/models"][0]), row[np.isfinite(row)], ideal)
    return lens.pixels_of(drawn, a["rig/intrinsics"][0])


def _mark(a: Mapping[str, np.ndarray], canvas: np.ndarray, centre: np.ndarray, low: np.ndarray, step: float) -> None:
    """Points of regard as rings."""
    import cv2

    if "por/points" not in a:
        return
    off = a["por/points"][a["por/outcome"] == "hit"] - centre
    lon, lat = np.arctan2(off[:, 0], off[:, 2]), np.arctan2(off[:, 1], np.hypot(off[:, 0], off[:, 2]))
    for x, y in zip((lon - low[0]) / step, (lat - low[1]) / step, strict=True):
        cv2.circle(canvas, (round(float(x)), round(float(y))), 4, LOOK, 1, cv2.LINE_AA)
