"""Make sample_data/shapes: eleven noisy depth maps of an invented still life, with poses, colour and the true depth.

    python tools/make_sample_data.py [FOLDER]

A room corner with a sphere, a glazed pot, a crate and a ring is cast ray by ray from an arc of cameras. The depth maps
then get what real ones have: Laplace noise, outliers, holes. Everything follows from the seed, so the same pixels come
out on every machine.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.geometry.cameras import rays
from ipcli.io.files.atomic import write_text
from ipcli.io.files.images import write_depth_png16, write_png
from ipcli.rng import stream

SEED = 4
VIEWS = 11
SHAPE = (240, 320)
INTRINSICS = np.array([[300.0, 0.0, 159.5], [0.0, 300.0, 119.5], [0.0, 0.0, 1.0]])
DEPTH_SCALE = 4000.0  # stored in quarters of a millimetre
LAPLACE = 0.02  # metres
OUTLIERS = 0.03  # share of the pixels
HOLES = 6  # a view
FAR = 1e9  # the distance of a miss: large, but it does not turn into NaN in arithmetic

TARGET = np.array([0.0, -0.42, 0.1])  # y points down, the floor is y = 0
ARC = np.radians(np.linspace(-14.0, 14.0, VIEWS))
LAMP = np.array([1.6, -3.2, -1.9])
SHADOW_RAYS = 10
LAMP_SPIRAL = (
    np.arange(SHADOW_RAYS)[:, None] * 2.39996
)  # golden angle: points spread evenly over a disc make the shadows soft
LAMP_POINTS = LAMP + 0.3 * np.sqrt(np.arange(SHADOW_RAYS)[:, None] / SHADOW_RAYS) * np.hstack(
    [np.cos(LAMP_SPIRAL), np.zeros((SHADOW_RAYS, 1)), np.sin(LAMP_SPIRAL)]
)


@dataclass(frozen=True)
class Body:
    """A surface: where rays meet it, its outward normal there, and its colour there."""

    meet: Callable[
        [np.ndarray, np.ndarray], np.ndarray
    ]  # (origins (n, 3), directions (n, 3)) -> distance (n,), FAR for none
    normal: Callable[[np.ndarray], np.ndarray]  # points (n, 3) -> (n, 3)
    colour: Callable[[np.ndarray], np.ndarray]  # points (n, 3) -> (n, 3) in [0, 1]


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors scaled to length 1 along the last axis."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def plane(axis: int, offset: float, towards: float) -> tuple[Callable, Callable]:
    """The plane where one coordinate is ``offset``; its normal points ``towards`` -1 or 1."""

    def meet(origins, directions):
        slope = np.where(np.abs(directions[:, axis]) < 1e-12, 1e-12, directions[:, axis])
        return forward((offset - origins[:, axis]) / slope)

    return meet, lambda points: np.broadcast_to(towards * np.eye(3)[axis], points.shape)


def forward(distance: np.ndarray) -> np.ndarray:
    """Distances behind the origin, or so near that they are the surface a ray leaves from, become a miss."""
    return np.where(distance > 1e-6, distance, FAR)


def quadratic(a: np.ndarray, half_b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both roots of a t^2 + 2 half_b t + c, and whether they are real."""
    discriminant = half_b**2 - a * c
    root = np.sqrt(np.maximum(discriminant, 0))
    return (-half_b - root) / a, (-half_b + root) / a, discriminant > 0


def sphere(centre: np.ndarray, radius: float) -> tuple[Callable, Callable]:
    def meet(origins, directions):
        offset = origins - centre
        near, _, real = quadratic(np.ones(len(offset)), (offset * directions).sum(1), (offset**2).sum(1) - radius**2)
        return np.where(real, forward(near), FAR)

    return meet, lambda points: (points - centre) / radius


def crate(centre: np.ndarray, half: np.ndarray, turn: float) -> tuple[Callable, Callable]:
    """A box turned about the vertical axis (radians)."""
    local = np.array([[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]])

    def meet(origins, directions):
        start, slope = (origins - centre) @ local.T, directions @ local.T
        slope = np.where(np.abs(slope) < 1e-12, 1e-12, slope)
        enter, leave = (-np.sign(slope) * half - start) / slope, (np.sign(slope) * half - start) / slope
        near, far = enter.max(1), leave.min(1)
        return np.where(near < far, forward(near), FAR)

    def normal(points):
        inside = ((points - centre) @ local.T) / half
        face = np.argmax(np.abs(inside), axis=1)
        return (np.eye(3)[face] * np.sign(inside[np.arange(len(face)), face])[:, None]) @ local

    return meet, normal


def pot(base: np.ndarray, radius: float, height: float) -> tuple[Callable, Callable]:
    """An upright closed cylinder that stands on ``base``."""
    top = base[1] - height

    def meet(origins, directions):
        offset, slope = (origins - base)[:, [0, 2]], directions[:, [0, 2]]
        near, _, real = quadratic(
            np.maximum((slope**2).sum(1), 1e-12), (offset * slope).sum(1), (offset**2).sum(1) - radius**2
        )
        side_y = origins[:, 1] + near * directions[:, 1]
        side = np.where(real & (side_y > top) & (side_y < base[1]), forward(near), FAR)
        lid = forward((top - origins[:, 1]) / np.where(np.abs(directions[:, 1]) < 1e-12, 1e-12, directions[:, 1]))
        within = ((offset + np.minimum(lid, 1e3)[:, None] * slope) ** 2).sum(1) < radius**2
        return np.minimum(side, np.where(within, lid, FAR))

    def normal(points):
        outward = (points - base) * [1, 0, 1] / radius
        return np.where((points[:, 1] < top + 1e-6)[:, None], [0.0, -1.0, 0.0], outward)

    return meet, normal


def ring(centre: np.ndarray, axis: np.ndarray, radius: float, thickness: float) -> tuple[Callable, Callable]:
    """A torus, by sphere tracing: its quartic is not worth the trouble for the few rays that pass near it."""
    axis = unit(axis)
    around, _ = sphere(centre, radius + thickness)

    def spine(points):
        """From the nearest point of the circle inside the ring to the points."""
        offset = points - centre
        flat = offset - (offset @ axis)[:, None] * axis
        return offset - radius * flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)

    def meet(origins, directions):
        # a start inside the bounding sphere has no entry point in front of it: begin at the origin there
        inside = ((origins - centre) ** 2).sum(1) <= (radius + thickness) ** 2
        distance = np.where(inside, 1e-4, around(origins, directions))
        active = np.flatnonzero(distance < FAR)
        travelled = distance[active]
        for _ in range(120):
            gap = np.linalg.norm(spine(origins[active] + travelled[:, None] * directions[active]), axis=1) - thickness
            travelled += gap
        distance[active] = np.where(np.abs(gap) < 1e-9, forward(travelled), FAR)
        return distance

    return meet, lambda points: unit(spine(points))


def paint(light: tuple, dark: tuple, pattern: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    """A colour between two (RGB in 0..255), where the pattern (n,) says how dark, from 0 to 1."""
    bright, deep = np.array(light) / 255, np.array(dark) / 255
    return lambda points: bright + (deep - bright) * pattern(points)[:, None]


def tiles(points: np.ndarray) -> np.ndarray:
    grid = np.floor(points[:, 0] / 0.3) + np.floor(points[:, 2] / 0.3)
    return 0.8 * (grid % 2) + 0.2 * grain(points, 40)


def bricks(points: np.ndarray) -> np.ndarray:
    row = np.floor(-points[:, 1] / 0.16)
    along, up = (points[:, 0] / 0.42 + 0.5 * (row % 2)) % 1, (-points[:, 1] / 0.16) % 1
    mortar = (along < 0.04) | (up < 0.09)
    return np.where(
        mortar,
        0.0,
        0.65
        + 0.25 * np.sin(12.9 * np.floor(points[:, 0] / 0.42 + 0.5 * (row % 2)) + 7.7 * row)
        + 0.1 * grain(points, 60),
    )


def stripes(points: np.ndarray) -> np.ndarray:
    return 0.7 * ((points[:, 2] / 0.24) % 1 < 0.5) + 0.3 * grain(points, 30)


def marble(points: np.ndarray) -> np.ndarray:
    return 0.5 + 0.5 * np.sin(22 * points[:, 1] + 14 * points[:, 0] + 5 * grain(points, 9))


def planks(points: np.ndarray) -> np.ndarray:
    return 0.75 * ((points[:, 1] / 0.11) % 1 < 0.12) + 0.25 * grain(points * [1, 5, 1], 14)


def glaze(points: np.ndarray) -> np.ndarray:
    wave = points[:, 1] / 0.14 + 0.12 * np.sin(9 * np.arctan2(points[:, 0] - 0.62, points[:, 2] - 0.35))
    return np.clip(3 * np.sin(2 * np.pi * wave) + 0.5, 0, 1)


def grain(points: np.ndarray, frequency: float) -> np.ndarray:
    """A smooth irregular pattern in [0, 1]: products of sines at ratios that do not repeat."""
    x, y, z = (frequency * points).T
    return 0.5 + 0.25 * (
        np.sin(x + 1.3 * np.sin(1.7 * y)) * np.sin(1.13 * z + y)
        + np.sin(2.3 * y + 1.1 * np.sin(1.9 * z)) * np.sin(2.1 * x)
    )


SCENE = (
    Body(*plane(1, 0.0, -1), paint((226, 206, 178), (128, 88, 62), tiles)),
    Body(*plane(2, 1.3, -1), paint((232, 226, 214), (186, 104, 76), bricks)),
    Body(*plane(0, -1.35, 1), paint((150, 186, 190), (92, 136, 148), stripes)),
    Body(*sphere(np.array([-0.42, -0.36, 0.15]), 0.36), paint((246, 240, 226), (52, 84, 110), marble)),
    Body(*sphere(np.array([0.16, -0.15, -0.42]), 0.15), paint((238, 176, 58), (200, 96, 36), marble)),
    Body(
        *crate(np.array([0.28, -0.24, 0.78]), np.array([0.33, 0.24, 0.22]), 0.5),
        paint((206, 164, 108), (112, 74, 42), planks),
    ),
    Body(*pot(np.array([0.62, 0.0, 0.12]), 0.2, 0.52), paint((94, 140, 106), (236, 232, 214), glaze)),
    Body(
        *ring(np.array([0.24, -0.70, 0.74]), np.array([0.5, 0.25, -1.0]), 0.17, 0.055),
        paint((196, 66, 70), (226, 120, 100), marble),
    ),
)


def cast(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance (n,) to the nearest body along each ray, and the index of that body."""
    distances = np.stack([body.meet(origins, directions) for body in SCENE])
    nearest = distances.argmin(axis=0)
    return distances[nearest, np.arange(len(nearest))], nearest


def shade(points: np.ndarray, bodies: np.ndarray) -> np.ndarray:
    """Colour (n, 3) of surface points: a lamp with soft shadows, light from the sky, a darker corner."""
    normals, colours = np.empty_like(points), np.empty_like(points)
    for index, body in enumerate(SCENE):
        own = bodies == index
        normals[own], colours[own] = body.normal(points[own]), body.colour(points[own])
    start = points + 1e-4 * normals
    lit = np.zeros(len(points))
    for lamp in LAMP_POINTS:
        to_lamp = lamp - start
        reach = np.linalg.norm(to_lamp, axis=1)
        seen = cast(start, to_lamp / reach[:, None])[0] > reach
        lit += seen * np.maximum((to_lamp * normals).sum(1) / reach, 0) * (3.4 / reach) ** 2
    sky = 0.5 - 0.5 * normals[:, 1]
    corner = np.clip(
        0.35 + 1.2 * np.minimum(1.35 - points[:, 2], np.minimum(points[:, 0] + 1.4, 0.05 - points[:, 1])), 0.55, 1
    )
    return colours * (0.85 * lit / SHADOW_RAYS + (0.22 + 0.2 * sky) * corner)[:, None]


def camera(angle: float) -> np.ndarray:
    """cam_from_world (4, 4) of the camera at one angle of the arc, looking at the target."""
    centre = TARGET + 2.55 * np.array([np.sin(angle), -0.42, -np.cos(angle)])
    z = unit(TARGET - centre)
    x = unit(np.cross([0.0, 1.0, 0.0], z))
    rotation = np.stack([x, np.cross(z, x), z])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, -rotation @ centre
    return pose


def trace(
    pose: np.ndarray, intrinsics: np.ndarray, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth (h, w), surface points (h * w, 3) in the world, and the body met (h * w,)."""
    through = rays(shape, intrinsics).reshape(-1, 3)
    length = np.linalg.norm(through, axis=1)
    centre = -pose[:3, :3].T @ pose[:3, 3]
    directions = (through / length[:, None]) @ pose[:3, :3]
    distance, bodies = cast(np.broadcast_to(centre, directions.shape), directions)
    return (distance / length).reshape(shape), centre + distance[:, None] * directions, bodies


def picture(pose: np.ndarray) -> np.ndarray:
    """The colour image (h, w, 3) uint8, averaged from two by two rays a pixel."""
    height, width = SHAPE
    fine = np.diag([2.0, 2.0, 1.0]) @ INTRINSICS
    fine[:2, 2] += 0.5
    _, points, bodies = trace(pose, fine, (2 * height, 2 * width))
    linear = shade(points, bodies).reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
    return np.rint(255 * np.clip(linear, 0, 1) ** (1 / 1.35)).astype(np.uint8)


def measured(truth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """What a poor sensor gives of the true depth: Laplace noise, outliers anywhere in the range, elliptic holes."""
    depth = truth + rng.laplace(scale=LAPLACE, size=truth.shape)
    outlier = rng.random(truth.shape) < OUTLIERS
    depth[outlier] = rng.uniform(truth.min(), truth.max(), np.count_nonzero(outlier))
    rows, columns = np.indices(truth.shape)
    for _ in range(HOLES):
        (row, column), (tall, wide) = rng.uniform(0, truth.shape), rng.uniform(5, 22, 2)
        depth[((rows - row) / tall) ** 2 + ((columns - column) / wide) ** 2 < 1] = np.nan
    return depth.astype(np.float32)


def write_view(folder: Path, name: str, angle: float) -> None:
    """The files of one view."""
    pose, rng = camera(angle), stream(SEED, "sample", name)
    truth = trace(pose, INTRINSICS, SHAPE)[0].astype(np.float32)
    write_depth_png16(folder / "depth" / f"{name}.png", measured(truth, rng), DEPTH_SCALE)
    write_depth_png16(folder / "truth" / f"{name}.png", truth, DEPTH_SCALE)
    write_png(folder / "image" / f"{name}.png", picture(pose))


def write_tables(folder: Path) -> None:
    """Intrinsics, poses and manifest of the whole sequence."""
    poses = (
        f"{name} {' '.join(f'{value:.9f}' for value in camera(angle)[:3].ravel())}" for name, angle in ANGLES.items()
    )
    write_text(
        folder / "poses.txt",
        "\n".join(["# cam_from_world: name, then the 3 x 4 matrix row by row, metres", *poses, ""]),
    )
    write_text(folder / "intrinsics.txt", "# fx fy cx cy, pixels\n300 300 159.5 119.5\n")
    write_text(folder / "views.toml", f'unit = "m"\ndepth_scale = {DEPTH_SCALE:g}  # stored value of one metre\n')


ANGLES = {f"{index:03d}": angle for index, angle in enumerate(ARC)}


def main() -> None:
    """Write the whole folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[1] / "sample_data" / "shapes")
    folder = parser.parse_args().folder
    for part in ("depth", "image", "truth"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    write_tables(folder)
    for name, angle in ANGLES.items():
        write_view(folder, name, angle)


if __name__ == "__main__":
    main()
