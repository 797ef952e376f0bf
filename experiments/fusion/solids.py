"""Meshes for a quick look at the rendered experiments, where no data set is at hand: `python solids.py
FOLDER/NAME.ply`.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

BALLS = ((0.5, (-0.4, -0.3, 0.2)), (0.35, (0.5, 0.1, 0.4)), (0.45, (0.1, 0.4, -0.5)))
RODS = (((-0.9, 0.6, 0.3), (0.8, -0.8, 0.1)), ((-0.7, -0.9, -0.4), (0.3, 0.9, 0.2)))


def joined(parts: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """All parts as one mesh."""
    whole = trimesh.util.concatenate(parts)
    assert isinstance(whole, trimesh.Trimesh)
    return whole


def torus() -> trimesh.Trimesh:
    """A ring about a ball, facing the camera."""
    return joined([trimesh.creation.torus(1.0, 0.3), trimesh.creation.icosphere(subdivisions=4, radius=0.55)])


def knot() -> trimesh.Trimesh:
    """Three balls and two rods, one behind the other."""
    balls = [trimesh.creation.icosphere(subdivisions=4, radius=r).apply_translation(at) for r, at in BALLS]
    return joined([*balls, *(trimesh.creation.cylinder(0.15, segment=ends, sections=64) for ends in RODS)])


def village() -> trimesh.Trimesh:
    """As the town, other heights."""
    return town(seed=1)


def town(seed: int = 0) -> trimesh.Trimesh:
    """Blocks of several heights and a tent roof on flat ground, in metres."""
    parts = [trimesh.creation.box(bounds=[(-300, -240, -1), (300, 240, 0)])]
    rng = np.random.default_rng(seed)
    for x in range(-120, 121, 60):
        for y in range(-90, 91, 60):
            parts.append(trimesh.creation.box(bounds=[(x - 18, y - 15, 0), (x + 18, y + 15, rng.uniform(8, 40))]))
    parts.append(
        trimesh.convex.convex_hull(
            np.array([(-40, -50, 0), (40, -50, 0), (40, -10, 0), (-40, -10, 0), (-30, -30, 30), (30, -30, 30)])
        )
    )
    return joined(parts)


def room() -> trimesh.Trimesh:
    """A room with a table, a shelf, a ball and a cylinder, in metres: x right, y down, z away, the floor at y = 1.2."""

    def box(*bounds):
        return trimesh.creation.box(bounds=np.reshape(bounds, (2, 3)))

    walls = [
        box(-2.6, 1.2, -1, 2.6, 1.3, 4),
        box(-2.6, -1.6, 3.6, 2.6, 1.2, 3.7),
        box(-2.6, -1.6, -1, -2.5, 1.2, 4),
        box(2.5, -1.6, -1, 2.6, 1.2, 4),
    ]
    table = [
        box(-0.9, 0.35, 1.9, 0.9, 0.42, 2.8),
        *(box(x, 0.42, z, x + 0.08, 1.2, z + 0.08) for x in (-0.85, 0.77) for z in (1.95, 2.67)),
    ]
    shelf = [box(1.5, y, 3.1, 2.4, y + 0.06, 3.6) for y in (-0.8, -0.2, 0.4)]
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.3).apply_translation((0.3, 0.05, 2.3))
    pot = trimesh.creation.cylinder(radius=0.2, height=0.5, sections=64).apply_transform(
        trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0), point=(0, 0, 0))
    )
    return joined([*walls, *table, *shelf, ball, pot.apply_translation((-0.45, 0.1, 2.4))])


def street(seed: int) -> trimesh.Trimesh:
    """A street between houses, with cars, in metres: x right, y down, z ahead, the road 1.65 below the camera."""
    rng, parts = np.random.default_rng(seed), [trimesh.creation.box(bounds=[(-60, 1.65, -5), (60, 2.0, 120)])]
    for side in (-1, 1):
        for z in np.arange(4.0, 100.0, 12.0):
            near, height = rng.uniform(5.0, 8.0), rng.uniform(5.0, 12.0)
            x = sorted((side * near, side * (near + 10)))
            far = z + rng.uniform(8.0, 11.5)
            parts.append(trimesh.creation.box(bounds=np.array([(x[0], 1.65 - height, z), (x[1], 1.7, far)])))
        for z in rng.uniform(8, 50, 3):
            centre = (side * rng.uniform(2.5, 3.5), 0.9, z)
            turn = trimesh.transformations.rotation_matrix(rng.normal(0, 0.1), (0, 1, 0))
            parts.append(trimesh.creation.box((1.7, 1.5, 4.0), turn).apply_translation(centre))
    parts.append(trimesh.creation.box(bounds=[(-60, -20, 110), (60, 2, 112)]))
    return joined(parts)


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.parent.mkdir(parents=True, exist_ok=True)
    {"torus": torus, "knot": knot, "town": town, "village": village}[path.stem]().export(path)
