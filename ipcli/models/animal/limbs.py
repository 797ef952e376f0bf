"""An animal of our own: round cones as limbs, in two poses, as a labelled mesh. For examples, tests and quick looks."""

from __future__ import annotations

import numpy as np

from ipcli.geometry import level_sets
from ipcli.measurements.part_images import PartTree

TREE = PartTree(
    ("torso", "neck", "head", "tail", "front_leg_L", "front_leg_R", "back_leg_L", "back_leg_R"),
    (-1, 0, 1, 0, 0, 0, 0, 0),
)
Limb = tuple[tuple[float, float, float], tuple[float, float, float], float, float]  # start, end, radii there
POSES = ("standing", "walking")


def limbs(pose: str = "standing") -> dict[str, list[Limb]]:
    """The round cones of each part: x forward, y to the left, z up, 2 long from chest to rump."""
    swing = {"standing": 0.0, "walking": 0.32}[pose]
    parts: dict[str, list[Limb]] = {
        "torso": [((-0.75, 0, 0), (0.0, 0, -0.04), 0.33, 0.36), ((0.0, 0, -0.04), (0.7, 0, 0.04), 0.36, 0.31)],
        "neck": [((0.8, 0, 0.12), (1.15, 0, 0.72), 0.22, 0.15)],
        "head": [((1.15, 0, 0.82), (1.55, 0, 0.66), 0.17, 0.09), ((1.1, 0.1, 0.95), (1.06, 0.14, 1.12), 0.05, 0.02),
                 ((1.1, -0.1, 0.95), (1.06, -0.14, 1.12), 0.05, 0.02)],
        "tail": [((-1.0, 0, 0.12), (-1.3, 0.05 + swing / 2, -0.35), 0.07, 0.04)],
    }  # fmt: skip
    for end, x in (("front", 0.62), ("back", -0.75)):
        for side, y in (("L", 0.17), ("R", -0.17)):
            step = swing * (1 if (end == "front") == (side == "L") else -1)
            knee, foot = (x + step * 0.6, y, -0.72), (x + step, y, -1.18)
            parts[f"{end}_leg_{side}"] = [((x, y, -0.2), knee, 0.17, 0.1), (knee, foot, 0.1, 0.085)]
    return parts


def round_cone(points: np.ndarray, limb: Limb) -> np.ndarray:
    """Nearly the signed distance (...) of points (..., 3) to a cone with round ends."""
    start, end, first, last = np.array(limb[0]), np.array(limb[1]), limb[2], limb[3]
    axis = end - start
    along = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
    return np.linalg.norm(points - start - along[..., None] * axis, axis=-1) - (first + along * (last - first))


def four_legged(pose: str = "standing", spacing: float = 0.03) -> tuple[np.ndarray, np.ndarray, np.ndarray, PartTree]:
    """Vertices (n, 3), faces (m, 3), the part + 1 of each face (m,) and the tree, of the animal in a pose."""
    shapes = limbs(pose)
    axes = [np.arange(low, high, spacing) for low, high in ((-1.6, 1.85), (-0.6, 0.6), (-1.45, 1.3))]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    def fields(points: np.ndarray) -> np.ndarray:
        return np.stack([np.min([round_cone(points, limb) for limb in shapes[name]], axis=0) for name in TREE.names])

    phi = level_sets.flow(fields(grid).min(axis=0) / spacing, 1.0)  # softens the creases between limbs
    vertices, faces = level_sets.mesh(phi, spacing, np.array([axis[0] for axis in axes]))
    labels = np.argmin(fields(vertices[faces].mean(axis=1)), axis=0) + 1
    return vertices, faces, labels.astype(np.int16), TREE
