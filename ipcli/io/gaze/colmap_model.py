"""A COLMAP model: cameras, images, points3D, in text and binary. COLMAP has the first pixel's centre at (0.5, 0.5).

Pictures are named after their frames, `left/NAME` and `right/NAME`. Readable by COLMAP and pycolmap, which make the
rigs themselves where those files do not tell.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import atomic

MODELS = {
    "pinhole": ("PINHOLE", 0),
    "radtan": ("FULL_OPENCV", 8),
    "equidistant": ("OPENCV_FISHEYE", 4),
    "fisheye624": ("RAD_TAN_THIN_PRISM_FISHEYE", 12),
}
NUMBERS = {"PINHOLE": 1, "FULL_OPENCV": 6, "OPENCV_FISHEYE": 5, "RAD_TAN_THIN_PRISM_FISHEYE": 11}  # in binary files
SIDES = ("left", "right")


def write_cameras(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line a camera; the correction of the right one's principal point is in it."""
    lines = ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"]
    for number, name, (width, height), values in cameras(a):
        lines.append(f"{number} {name} {width} {height} " + " ".join(f"{value:.12g}" for value in values))
    atomic.write_text(path, "\n".join(lines) + "\n")


def write_cameras_binary(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The same as cameras.bin."""
    parts = [struct.pack("<Q", len(a["rig/models"]))]
    for number, name, (width, height), values in cameras(a):
        parts.append(struct.pack(f"<iiQQ{len(values)}d", number, NUMBERS[name], width, height, *values))
    atomic.write_bytes(path, b"".join(parts))


def cameras(a: Mapping[str, np.ndarray]) -> list[tuple[int, str, tuple[int, int], tuple[float, ...]]]:
    """(camera id, COLMAP's model, width and height, its parameters) of each camera."""
    found = []
    for c, model in enumerate(a["rig/models"]):
        name, count = MODELS[str(model)]
        k = a["rig/intrinsics"][c]
        offset = float(a["offset"]) if c == 1 else 0.0
        coefficients = np.nan_to_num(a["rig/distortion"][c][:count])
        values = (k[0, 0], k[1, 1], k[0, 2] + offset + 0.5, k[1, 2] + 0.5, *coefficients)
        width, height = (int(side) for side in a["rig/sizes"][c])
        found.append((c + 1, name, (width, height), tuple(float(value) for value in values)))
    return found


def images(a: Mapping[str, np.ndarray]) -> list[tuple[int, int, int]]:
    """(image id, frame, camera) of every picture whose pose is known."""
    cameras = len(a["rig/models"])
    return [
        (frame * cameras + camera + 1, frame, camera)
        for frame in np.flatnonzero(a["lost"] == 0).tolist()
        for camera in range(cameras)
    ]


def write_images(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Two lines a picture: pose (camera from world) and the map points it shows."""
    from scipy.spatial.transform import Rotation

    lines = ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "# POINTS2D[] as (X, Y, POINT3D_ID)"]
    rows = _rows(a)
    for image, frame, camera in images(a):
        pose = a["rig/cam_from_rig"][camera] @ np.linalg.inv(a["world_from_rig"][frame])
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        numbers = " ".join(f"{value:.12g}" for value in (w, x, y, z, *pose[:3, 3]))
        lines.append(f"{image} {numbers} {camera + 1} {SIDES[camera]}/{a['names'][frame]}")
        mine = rows.get((int(frame), camera), ())
        pixels = a["map/pixels"]
        lines.append(
            " ".join(f"{pixels[m, 0] + 0.5:.4f} {pixels[m, 1] + 0.5:.4f} {a['map/sightings'][m, 2] + 1}" for m in mine)
        )
    atomic.write_text(path, "\n".join(lines) + "\n")


def write_images_binary(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The same as images.bin."""
    from scipy.spatial.transform import Rotation

    rows, posed = _rows(a), images(a)
    parts = [struct.pack("<Q", len(posed))]
    table = np.dtype([("pixel", "<f8", 2), ("point", "<u8")])
    for image, frame, camera in posed:
        pose = a["rig/cam_from_rig"][camera] @ np.linalg.inv(a["world_from_rig"][frame])
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        name = f"{SIDES[camera]}/{a['names'][frame]}".encode() + b"\0"
        mine = rows.get((int(frame), camera), [])
        seen = np.zeros(len(mine), table)
        seen["pixel"], seen["point"] = a["map/pixels"][mine] + 0.5, a["map/sightings"][mine, 2] + 1
        parts += [struct.pack("<I7dI", image, w, x, y, z, *pose[:3, 3], camera + 1), name]
        parts += [struct.pack("<Q", len(mine)), seen.tobytes()]
    atomic.write_bytes(path, b"".join(parts))


def _rows(a: Mapping[str, np.ndarray]) -> dict[tuple[int, int], list[int]]:
    """Rows of the sightings by frame and camera."""
    found: dict[tuple[int, int], list[int]] = {}
    for m, (frame, camera, _) in enumerate(a["map/sightings"]):
        found.setdefault((int(frame), int(camera)), []).append(m)
    return found


def write_points(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line a point with its track."""
    lines = ["# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"]
    for p, (point, grey, track) in enumerate(zip(a["map/points"], a["map/grey"], _tracks(a), strict=True), start=1):
        place = " ".join(f"{value:.9g}" for value in point)
        lines.append(f"{p} {place} {grey} {grey} {grey} 0 " + " ".join(f"{image} {order}" for image, order in track))
    atomic.write_text(path, "\n".join(lines) + "\n")


def write_points_binary(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The same as points3D.bin."""
    parts = [struct.pack("<Q", len(a["map/points"]))]
    for p, (point, grey, track) in enumerate(zip(a["map/points"], a["map/grey"], _tracks(a), strict=True), start=1):
        parts.append(struct.pack("<Q3d3BdQ", p, *point, *[int(grey)] * 3, 0.0, len(track)))
        parts.append(np.array(track, "<u4").tobytes())
    atomic.write_bytes(path, b"".join(parts))


def _tracks(a: Mapping[str, np.ndarray]) -> list[list[tuple[int, int]]]:
    """For each point of the map the pictures that show it: (image id, row among that picture's points)."""
    count = len(a["rig/models"])
    tracks: list[list[tuple[int, int]]] = [[] for _ in a["map/points"]]
    for (frame, camera), rows in _rows(a).items():
        for order, m in enumerate(rows):
            tracks[a["map/sightings"][m, 2]].append((frame * count + camera + 1, order))
    return tracks
