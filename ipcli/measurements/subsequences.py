"""Stretches of a posed recording with the scene before them and the points that were looked at meanwhile.

Frames of cameras are x right, y down, z forward; metres, seconds; pixels have their centres at integers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ipcli.geometry import lens
from ipcli.measurements.recording import Camera


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A picture with its pose."""

    frame: int  # its number in the recording
    image: np.ndarray  # (h, w, 3) uint8
    cam_from_world: np.ndarray  # (4, 4)


@dataclass(frozen=True, eq=False)
class Subsequence:
    """Frames with one focus of attention (or some that follow each other), and what is known of them."""

    number: int
    frames: tuple[int, int]  # the first, and the one after the last
    times: tuple[float, float]  # seconds, of the first and of the last
    cloud: np.ndarray  # (n, 3) points of the scene in the world
    cam_from_world: np.ndarray  # (4, 4) of the reference camera
    snapshots: tuple[Snapshot, ...]  # pictures to look at: its own, or the nearest in time
    regards: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))  # (m, 3) points of regard in the world


@dataclass(frozen=True, eq=False)
class PosedSequence:
    """A recording as subsequences, each read only when asked for."""

    count: int
    load: Callable[[int], Subsequence]
    camera: Camera  # of the snapshots, at their size
    files: tuple[Path, ...]  # everything it was made of, for the provenance
    regards: np.ndarray  # (n, 3) all points of regard, in order of time
    regard_frames: np.ndarray  # (n,) frame of each
    source: str
    notes: tuple[str, ...] = ()  # what a reader must be told


def seen_at(camera: Camera, cam_from_world: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) at which a camera sees points (n, 3) of the world; NaN behind it or outside the picture."""
    seen = points @ cam_from_world[:3, :3].T + cam_from_world[:3, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        ideal = seen[:, :2] / np.where(seen[:, 2:] > 1e-3, seen[:, 2:], np.nan)
    pixels = lens.pixels_of(lens.distort(camera.model, camera.distortion, ideal), camera.intrinsics)
    with np.errstate(invalid="ignore"):
        inside = np.logical_and(pixels >= -0.5, pixels <= np.array(camera.size) - 0.5).all(axis=1)
    return np.where(np.asarray(inside)[:, None], pixels, np.nan)


def before(camera: Camera, cam_from_world: np.ndarray, points: np.ndarray, cell: int = 4) -> np.ndarray:
    """Of points (n, 3) of the world those that a camera sees: the nearest of each cell of so many pixels, and others of
    the cell that lie no more than a twentieth behind it.
    """
    pixels = seen_at(camera, cam_from_world, points)
    seen = np.flatnonzero(np.isfinite(pixels[:, 0]))
    at = np.floor((pixels[seen] + 0.5) / cell).astype(np.int64)
    number = at[:, 1] * (camera.size[0] // cell + 2) + at[:, 0]
    depth = points[seen] @ cam_from_world[2, :3] + cam_from_world[2, 3]
    nearest = np.full(int(number.max(initial=0)) + 1, np.inf)
    np.minimum.at(nearest, number, depth)
    return points[seen[depth <= 1.05 * nearest[number]]]


def over_cloud(sequence: PosedSequence, cloud: np.ndarray, files: tuple[Path, ...]) -> PosedSequence:
    """The recording with another cloud (n, 3) for its scene: of each subsequence what its reference camera sees."""

    def load(number: int) -> Subsequence:
        sub = sequence.load(number)
        return replace(sub, cloud=before(sequence.camera, sub.cam_from_world, cloud))

    return replace(sequence, load=load, files=(*sequence.files, *files))
