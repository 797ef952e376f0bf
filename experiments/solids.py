"""Meshes for a quick look at the rendered experiments, where no data set is at hand: `python solids.py FOLDER/torus.ply`."""

import sys
from pathlib import Path

import numpy as np
import trimesh


def torus() -> trimesh.Trimesh:
    """A ring about a ball, facing the camera."""
    return trimesh.util.concatenate([trimesh.creation.torus(1.0, 0.3), trimesh.creation.icosphere(subdivisions=4, radius=0.55)])


def town() -> trimesh.Trimesh:
    """Blocks of several heights and a tent roof on flat ground, in metres."""
    parts = [trimesh.creation.box(bounds=[(-300, -240, -1), (300, 240, 0)])]
    rng = np.random.default_rng(0)
    for x in range(-120, 121, 60):
        for y in range(-90, 91, 60):
            parts.append(trimesh.creation.box(bounds=[(x - 18, y - 15, 0), (x + 18, y + 15, rng.uniform(8, 40))]))
    parts.append(trimesh.convex.convex_hull(np.array([(-40, -50, 0), (40, -50, 0), (40, -10, 0), (-40, -10, 0), (-30, -30, 30), (30, -30, 30)])))
    return trimesh.util.concatenate(parts)


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.parent.mkdir(parents=True, exist_ok=True)
    {"torus": torus, "town": town}[path.stem]().export(path)
