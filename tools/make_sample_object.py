"""Make sample_data/brdf/vase: a photograph of a glazed vase, its mask and its true heights.

brdf-model did not render it: here every pixel gathers light over the sphere with cast shadows, which the reflectance
maps of the model know nothing of, and the material is none of sample_data/brdf/materials.toml.
"""

from pathlib import Path

import numpy as np

from ipcli.io.files import images, npz
from ipcli.models.brdf import surfaces
from ipcli.models.brdf.light import sphere
from ipcli.models.brdf.materials import Plastic
from ipcli.models.brdf.reflectance import frames

SIDE = 200
DIRECTIONS = 900
STEPS = 24  # along a shadow ray
GLAZE = Plastic((0.12, 0.32, 0.36), 1.55, 0.16)
PLACE = Path(__file__).resolve().parent.parent / "sample_data" / "brdf"


def vase() -> surfaces.Implicit:
    """A belly, a neck and a lip, leaning a little towards the viewer."""
    body = surfaces.revolved(lambda t: 0.3 + 0.15 * np.sin(2.4 * t - 1.2 + np.pi / 2) + 0.05 * np.cos(6 * t), 0.85)
    c, s = np.cos(0.25), np.sin(0.25)
    return surfaces.turned(body, np.array([[1, 0, 0], [0, c, s], [0, -s, c]]))


def light(directions: np.ndarray) -> np.ndarray:
    """A window at the upper left, a lamp at the right, and a bright ceiling."""
    window = np.exp(14 * (directions @ (np.array([-0.6, 0.45, 0.66])) - 1)) * 5
    lamp = np.exp(40 * (directions @ (np.array([0.75, 0.3, 0.59])) - 1)) * 4
    return 0.12 + 0.3 * np.clip(directions[:, 1], 0, 1) + window + lamp


def gathered(inside: surfaces.Implicit, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Radiance (n, 3) of surface points towards the viewer, with cast shadows."""
    directions = sphere(DIRECTIONS)
    radiance = light(directions)
    turned = frames(normals)
    seen = np.zeros_like(points)
    for direction, bright in zip(directions, radiance, strict=True):
        cosine = normals @ direction
        lit = np.flatnonzero(cosine > 0)
        way = np.linspace(0.04, 1.2, STEPS)[:, None, None] * direction + points[lit]
        lit = lit[(inside(way) > 0).all(axis=0)]
        local = turned[lit] @ direction
        seen[lit] += GLAZE(local, turned[lit, :, 2]) * (cosine[lit] * bright)[:, None] * (4 * np.pi / DIRECTIONS)
    return seen


def main() -> None:
    """Write the three files."""
    inside = vase()
    made = surfaces.march(inside, SIDE)
    rows, columns = np.nonzero(made.mask)
    half = SIDE / 2
    points = np.stack([(columns + 0.5) / half - 1, 1 - (rows + 0.5) / half, made.height[made.mask] / half], axis=-1)
    picture = np.full((SIDE, SIDE, 3), 0.02)
    seen = gathered(inside, points, made.normals[made.mask])
    picture[made.mask] = seen / np.percentile(seen, 99.3)
    picture += 0.004 * np.random.default_rng(0).normal(size=picture.shape)
    shown = np.clip(picture, 0, 1)
    srgb = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * np.maximum(shown, 1e-9) ** (1 / 2.4) - 0.055)
    images.write_png(PLACE / "vase.png", np.rint(255 * srgb).astype(np.uint8))
    images.write_png(PLACE / "vase.mask.png", (255 * made.mask).astype(np.uint8))
    npz.write(PLACE / "vase.height.npz", {"height": made.height.astype(np.float16).astype(np.float32)})


if __name__ == "__main__":
    main()
