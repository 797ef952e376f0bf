"""Features of surface points, F1 to F7 of 3.3 and some beside them, as named columns with units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.measurements.recording import Camera
from ipcli.measurements.subsequences import Subsequence, seen_at
from ipcli.models.saliency import membranes
from ipcli.models.saliency.channels import gaussian_curvature
from ipcli.models.saliency.scene_parameters import Membranes
from ipcli.models.saliency.surface import PlateSurface

FARTHEST, ACUTE = 3.0, 15.0  # metres, degrees: limits of (F7)
WIDEST, NARROWEST = 5.0, 1.0  # radius of a membrane
SMOOTHING = 1.5  # pixels: of the picture before its curvature is taken
AROUND = 8.0  # pixels: of the neighbourhood whose colours count too
RELIEF = 10.0  # pixels: how high the surface of intensity stands for white over black
LEAST, MOST = 0.2, 2.0  # sigma of (3.28) after scaling


@dataclass(frozen=True)
class Column:
    """A feature: its name, its unit and the group that is kept or left out as a whole."""

    name: str
    unit: str
    group: str


COLUMNS = (
    Column("x", "m", "F1"),
    Column("y", "m", "F1"),
    Column("z", "m", "F1"),
    Column("curvature of the surface", "1/m", "F2"),
    Column("inside the task domain", "1", "F3"),
    Column("time", "s", "F4"),
    Column("red", "1", "F5"),
    Column("green", "1", "F5"),
    Column("blue", "1", "F5"),
    Column("curvature of the picture", "1/px", "F6"),
    Column("patch size", "px", "F7"),
    Column("mean curvature", "1/m", "bend"),
    Column("height", "m", "height"),
    Column("angle from the middle", "deg", "centre"),
    Column("unlikeness in colour", "1", "contrast"),
    Column("red around", "1", "around"),
    Column("green around", "1", "around"),
    Column("blue around", "1", "around"),
    Column("membrane", "log", "membrane"),
)
GROUPS = tuple(dict.fromkeys(column.group for column in COLUMNS))
DOMAIN = 4  # the column that is only known once it is known who looked where
COUNT = len(COLUMNS)


@dataclass(frozen=True, eq=False)
class Membrane:
    """What excites the membrane at each node (n,)."""

    sigma: np.ndarray
    z: np.ndarray
    radius: np.ndarray


@dataclass(frozen=True, eq=False)
class NodeFeatures:
    """The nodes of a subsequence's surface that points of the scene bear out."""

    points: np.ndarray  # (n, 3) world, metres
    table: np.ndarray  # (n, COUNT) float32
    membrane: Membrane
    grid: tuple[int, int]  # rows and columns of all nodes
    place: np.ndarray  # (n,) where on the grid each node is, row by row


def of_nodes(sub: Subsequence, surface: PlateSurface, camera: Camera, start: np.ndarray, p: Membranes) -> NodeFeatures:
    """The table of a subsequence; `start` (3,) is where the search began, the origin of (F1)."""
    world_from_cam = np.linalg.inv(sub.cam_from_world)
    place = np.flatnonzero(surface.known.ravel())
    seen = surface.points.reshape(-1, 3)[place]
    points = seen @ world_from_cam[:3, :3].T + world_from_cam[:3, 3]
    rgb, bend, unlike, around = _of_pictures(sub, camera, points)
    gaussian, mean = (np.sqrt(np.abs(surface.gaussian.ravel()[place])), surface.mean.ravel()[place])
    membrane = _membrane(gaussian, bend, seen[:, 2])
    window = max(sub.times[1] - sub.times[0], 1e-3)
    energy = membranes.energies(membrane.sigma, membrane.z, membrane.radius, window, p)
    angle = np.degrees(np.arctan2(np.hypot(seen[:, 0], seen[:, 1]), seen[:, 2]))
    focal = float(camera.intrinsics[[0, 1], [0, 1]].mean())
    middle = (sub.times[0] + sub.times[1]) / 2
    columns = [
        *(points - start).T, gaussian, np.zeros(len(points)), np.full(len(points), middle), *rgb.T, bend,
        patch_size(seen[:, 2], focal), mean, points[:, 1], angle, unlike, *around.T,
        np.log(np.maximum(energy, 1e-30)),
    ]  # fmt: skip
    table = np.stack(columns, axis=1).astype(np.float32)
    return NodeFeatures(points, table, membrane, surface.known.shape, place)


def patch_size(depth: np.ndarray, focal: float) -> np.ndarray:
    """(F7): pixels of a patch of the scene that fills the acute angle at `FARTHEST` metres, or nearer."""
    return 2 * focal * np.tan(np.radians(ACUTE) / 2) * np.minimum(depth, FARTHEST) / depth


def _membrane(gaussian: np.ndarray, bend: np.ndarray, depth: np.ndarray) -> Membrane:
    """sigma = sigma_S + sigma_L of magnitudes, scaled to the subsequence; z the distance over its median."""
    sigma = np.clip(_scaled(gaussian) + _scaled(bend), LEAST, MOST)
    radius = np.clip(WIDEST * np.minimum(1.0, FARTHEST / depth), NARROWEST, WIDEST)
    return Membrane(sigma, np.clip(depth / np.median(depth), 0.2, 5.0), radius)


def _scaled(values: np.ndarray) -> np.ndarray:
    """Over nine tenths of their own: robust against a few sharp creases."""
    return values / max(float(np.percentile(values, 90)), 1e-12)


def excited(membrane: Membrane, saliency: np.ndarray) -> Membrane:
    """The membrane with a learnt saliency in [0, 1] in the place of curvature."""
    return Membrane(LEAST + (MOST - LEAST) * saliency, membrane.z, membrane.radius)


def _of_pictures(sub: Subsequence, camera: Camera, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """RGB in [0, 1], curvature of intensity, unlikeness in colour and RGB around of points, the mean over the pictures
    that show them. What no picture shows takes the mean over the others.
    """
    total, count = np.zeros((len(points), 8)), np.zeros(len(points))
    for shot in sub.snapshots:
        pixels = seen_at(camera, shot.cam_from_world, points)
        seen = np.isfinite(pixels[:, 0])
        total[seen] += _sampled(channels(shot.image), pixels[seen])
        count[seen] += 1
    known = count > 0
    fallback = total[known].sum(axis=0) / max(count.sum(), 1)
    mean = np.where(known[:, None], total / np.maximum(count, 1)[:, None], fallback)
    return mean[:, :3], mean[:, 3], mean[:, 4], mean[:, 5:]


def channels(image: np.ndarray) -> np.ndarray:
    """(h, w, 8): smoothed RGB in [0, 1], sqrt |sigma_L| of (3.16), distance of the colour from the picture's mean, RGB
    around.
    """
    from scipy.ndimage import gaussian_filter

    rgb, around = (
        np.stack([gaussian_filter(image[..., k] / 255.0, width) for k in range(3)], axis=-1)
        for width in (SMOOTHING, AROUND)
    )
    gaussian = gaussian_curvature(RELIEF * rgb.mean(axis=-1))
    spread = np.linalg.inv(np.cov(rgb.reshape(-1, 3).T) + 1e-4 * np.eye(3))
    off = rgb - rgb.reshape(-1, 3).mean(axis=0)
    unlike = np.sqrt(np.einsum("hwi,ij,hwj->hw", off, spread, off))
    return np.concatenate([rgb, np.sqrt(np.abs(gaussian))[..., None], unlike[..., None], around], axis=-1)


def _sampled(image: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Values (n, c) of an image (h, w, c) at pixels (n, 2), bilinear."""
    from scipy.ndimage import map_coordinates

    at = pixels.T[::-1]
    return np.stack(
        [map_coordinates(image[..., k], at, order=1, mode="nearest") for k in range(image.shape[2])], axis=1
    )


def columns_of(groups: tuple[str, ...]) -> np.ndarray:
    """Numbers of the columns that belong to some groups."""
    return np.array([k for k, column in enumerate(COLUMNS) if column.group in groups], int)


def task_domain(attended: np.ndarray, margin: float) -> np.ndarray:
    """R_tau of (F3) (2, 3): least and greatest coordinates of attended points (n, 3), a few strays apart."""
    return np.stack([np.percentile(attended, 2, axis=0) - margin, np.percentile(attended, 98, axis=0) + margin])


def with_domain(table: np.ndarray, domain: np.ndarray) -> np.ndarray:
    """Rows (n, COUNT) float64 with what is only known once there is a task domain (2, 3): whether they lie in it."""
    filled = table.astype(np.float64)
    filled[:, DOMAIN] = inside(table[:, :3], domain)
    return filled


def inside(points: np.ndarray, domain: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) lie in a domain (2, 3)."""
    return ((points >= domain[0]) & (points <= domain[1])).all(axis=1)
