"""Small generated sets: pictures whose coloured disc is looked at, balls whose bump is."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from ipcli.io.files import atomic, images, npz


def pictures(folder: Path, count: int = 8) -> None:
    """Noise with a disc; four observers, six fixations each."""
    lines = ["picture,x,y,observer"]
    v, u = np.mgrid[0:96, 0:128]
    for k in range(count):
        rng = np.random.default_rng(k)
        canvas = rng.integers(90, 130, (96, 128, 3)).astype(np.uint8)
        x, y = rng.integers(24, (104, 72))
        canvas[(u - x) ** 2 + (v - y) ** 2 < 100] = (220, 40, 40)
        images.write_png(folder / f"p{k}.png", canvas)
        spread = rng.normal(0, 5, (24, 2))
        lines += [f"p{k}.png,{x + dx:.1f},{y + dy:.1f},{n % 4}" for n, (dx, dy) in enumerate(spread)]
    atomic.write_text(folder / "fixations.csv", "\n".join(lines) + "\n")


def surfaces(folder: Path, count: int = 4) -> None:
    """Balls with a bump."""
    for k in range(count):
        rng = np.random.default_rng(k)
        normals, top = rng.normal(size=(2000, 3)), rng.normal(size=3)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        bump = np.exp(-((1 - normals @ top / np.linalg.norm(top)) ** 2) / 0.005)
        times = np.where(bump > 0.5, bump, 0)
        arrays = {"xyz": normals * (1 + 0.25 * bump)[:, None], "normal": normals, "fix_time": times}
        npz.write(folder / f"ball{k}.npz", {**arrays, "label": (times > 0).astype(np.float32)})


if __name__ == "__main__":
    pictures(Path(sys.argv[1]) / "pictures")
    surfaces(Path(sys.argv[1]) / "surfaces")
