"""Poses of a skeleton as SVG, from the front and from the side, one group of joints picked out (thesis figure 5.6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.report.kit.page import Markup, element

HEIGHT = 150  # pixels of a drawing
MARGIN = 0.06  # of its height, around the poses
UP = 1
FRONT, RIGHT = 0, 2  # the axis across the picture: a body faces along +z, y up, its left along +x


def pose_figure(
    poses: Sequence[np.ndarray],
    parents: np.ndarray,
    picked: np.ndarray,
    caption: object,
    note: object = "",
    *,
    box: tuple[np.ndarray, np.ndarray] | None = None,
    height: int = HEIGHT,
) -> Markup:
    """Poses (each (j, 3), turned to face +z, y up) over each other, the first in full and the others faint, front and
    side by side.

    ``parents`` (j,) has -1 for the root, ``picked`` (j,) is True for the joints of the group. ``box`` holds the least
    and greatest corner to draw, so that figures side by side have one scale.
    """
    low, high = box or bounds(poses)
    pad = MARGIN * max(float(high[UP] - low[UP]), 1e-6)
    scale = height / (float(high[UP] - low[UP]) + 2 * pad)
    drawings, at = [], 0.0
    for across in (FRONT, RIGHT):
        corner = np.array([low[across] - pad, high[UP] + pad])
        for index, pose in list(enumerate(poses))[::-1]:
            flat = (pose[:, [across, UP]] - corner) * [scale, -scale] + [at, 0.0]
            drawings += _body(flat, parents, picked, faint=index > 0)
        at += scale * (float(high[across] - low[across]) + 2 * pad)
    label = f"{caption}, from the front and from the right"
    drawing = element("svg", *drawings, class_="pose", viewBox=f"0 0 {at:.0f} {height}", role="img", aria_label=label)
    return element(
        "figure", drawing, element("figcaption", element("b", caption), element("span", note) if note else "")
    )


def bounds(poses: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest corner (3,) of all joints that are known; of nothing, a cube of a metre."""
    points = np.concatenate([np.reshape(pose, (-1, 3)) for pose in poses]) if len(poses) else np.empty((0, 3))
    points = points[np.isfinite(points).all(axis=1)]
    return (points.min(axis=0), points.max(axis=0)) if len(points) else (np.full(3, -0.5), np.full(3, 0.5))


def _body(flat: np.ndarray, parents: np.ndarray, picked: np.ndarray, *, faint: bool) -> list[Markup]:
    """Bones as one path for the group and one for the rest, and a dot at the joints of the group."""
    known = np.isfinite(flat).all(axis=1)
    bones = [(joint, parent) for joint, parent in enumerate(parents) if parent >= 0 and known[joint] and known[parent]]
    parts = []
    for mine, name in ((False, "rest"), (True, "group")):
        path = "".join(_bone(flat[parent], flat[joint]) for joint, parent in bones if picked[joint] == mine)
        if path and not (faint and not mine):
            parts.append(element("path", class_=f"{name} faint" if faint else name, d=path))
    if not faint:
        dots = (flat[joint] for joint in np.flatnonzero(picked & known))
        parts += [element("circle", class_="joint", cx=f"{x:.1f}", cy=f"{y:.1f}", r=2.4) for x, y in dots]
    return parts


def _bone(start: np.ndarray, end: np.ndarray) -> str:
    return f"M{start[0]:.1f} {start[1]:.1f}L{end[0]:.1f} {end[1]:.1f}"
