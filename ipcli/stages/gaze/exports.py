"""What gaze-sfm writes beside its artefact, for other programs: CSV, TUM trajectory, PLY, COLMAP model."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.io.files import atomic, ply
from ipcli.io.gaze import colmap_model, trajectories
from ipcli.io.meshes import turntable
from ipcli.stages.kit.artefact import Beside
from ipcli.stages.kit.pages import turning_page

PATH_COLOUR, RAY_COLOUR, POR_COLOUR = (40, 90, 220), (240, 170, 40), (220, 40, 40)
RAY_POINTS = 24  # along each gaze ray of the PLY
RAYS = 400  # most rays drawn
MOST = 20_000  # points of the map on the page to be turned


def beside(output: Path, *, has_gaze: bool, has_areas: bool = False) -> dict[Path, Beside]:
    """Side files of an experiment at `output`, with their writers."""
    files: dict[Path, Beside] = {
        output.with_suffix(".tum"): write_tum,
        output.with_suffix(".ply"): write_ply,
        turning_page(output): partial(write_turnable, f"gaze-sfm: {output.name}"),
        output.with_suffix(".cameras.txt"): colmap_model.write_cameras,
        output.with_suffix(".images.txt"): colmap_model.write_images,
        output.with_suffix(".points3D.txt"): colmap_model.write_points,
        output.with_suffix(".cameras.bin"): colmap_model.write_cameras_binary,
        output.with_suffix(".images.bin"): colmap_model.write_images_binary,
        output.with_suffix(".points3D.bin"): colmap_model.write_points_binary,
    }
    if has_areas:
        files[output.with_suffix(".aoi.csv")] = write_areas
    return files | ({output.with_suffix(".por.csv"): write_csv} if has_gaze else {})


def write_tum(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """world_from_camera of camera 0, lost frames left out."""
    atomic.write_text(path, trajectories.write_tum(a["times"], a["world_from_rig"], f"gaze-sfm {provenance['digest']}"))


COLUMNS = (
    "time [s]", "outcome", "x [m]", "y [m]", "z [m]", "sigma [m]", "sigma [deg]", "range [m]", "frame", "subsequence",
    "fixation", "px", "py", "pz", "qx", "qy", "qz", "qw",
)  # fmt: skip


def write_csv(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line a gaze sample: its point of regard with its sigma, and the head pose of its frame; empty where unknown."""
    from scipy.spatial.transform import Rotation

    lines = [",".join(COLUMNS)]
    for n, time in enumerate(a["gaze/times"]):
        frame = int(a["por/frame"][n])
        pose = a["world_from_rig"][frame] if frame >= 0 else np.full((4, 4), np.nan)
        placed = np.isfinite(pose).all()
        quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat() if placed else np.full(4, np.nan)
        point, covariance = a["por/points"][n], a["por/covariance"][n]
        distance = float(np.linalg.norm(point - a["por/origins"][n]))
        sigma = float(np.sqrt(np.trace(covariance)))
        ray = a["por/directions"][n]
        across = (
            float(np.sqrt(max(np.trace(covariance) - ray @ covariance @ ray, 0.0) / 2)) if sigma == sigma else sigma
        )
        values = (*point, sigma, np.degrees(np.arctan2(across, distance)), distance)
        pair = (frame, int(a["subsequence"][frame]) if frame >= 0 else -1, int(a["por/fixation"][n]))
        cells = [f"{time:.6f}", str(a["por/outcome"][n]), *map(_cell, values), *map(str, pair)]
        lines.append(",".join([*cells, *map(_cell, (*pose[:3, 3], *quaternion))]))
    atomic.write_text(path, "\n".join(lines) + "\n")


def write_areas(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A line an area of interest: dwell, share, visits, fixations, first look, and the transitions to each other."""
    names, text = a["aoi/names"].tolist(), io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    head = ("area", "dwell [s]", "share", "visits", "fixations", "first look [s]")
    lines.writerow([*head, *(f"to {name}" for name in names)])
    for i, name in enumerate(names):
        seconds, share, first = (_cell(a[f"aoi/{what}"][i]) for what in ("dwell", "share", "first"))
        counts = (a["aoi/visits"][i], a["aoi/fixations"][i])
        lines.writerow([name, seconds, share, *counts, first, *a["aoi/transitions"][i]])
    atomic.write_text(path, text.getvalue())


def _cell(value: float) -> str:
    return f"{value:.6g}" if np.isfinite(value) else ""


def write_ply(path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """Map, head path, gaze rays and points of regard as one coloured cloud; `part` tells them apart (0, 1, 2, 3)."""
    known = np.isfinite(a["world_from_rig"]).all(axis=(1, 2))
    parts = [(a["map/points"], np.repeat(a["map/grey"][:, None], 3, axis=1))]
    parts.append(_painted(a["world_from_rig"][known, :3, 3], PATH_COLOUR))
    if "por/points" in a:
        hit = np.flatnonzero(a["por/outcome"] == "hit")
        drawn = hit[:: max(1, len(hit) // RAYS)]
        share = np.linspace(0, 1, RAY_POINTS)[:, None, None]
        rays = (1 - share) * a["por/origins"][drawn] + share * a["por/points"][drawn]
        parts += [_painted(rays.reshape(-1, 3), RAY_COLOUR), _painted(a["por/points"][hit], POR_COLOUR)]
    part = np.concatenate([np.full(len(points), n, np.uint8) for n, (points, _) in enumerate(parts)])
    ply.write(
        path,
        np.concatenate([points for points, _ in parts]).astype(np.float32),
        colors=np.concatenate([colours for _, colours in parts]),
        extra={"part": part},
        comments=(f"ipcli gaze-sfm, unit m, digest {provenance['digest']}", "part 0 map, 1 head, 2 rays, 3 regard"),
    )


def _painted(points: np.ndarray, colour: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    return points, np.tile(np.array(colour, np.uint8), (len(points), 1))


def write_turnable(title: str, path: Path, a: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """A page with the map, the path and the points of regard to be turned; everything it needs is inside."""
    points = a["map/points"]
    chosen = np.flatnonzero(a["map/seen"] > 1)
    chosen = chosen[:: max(1, len(chosen) // MOST)]
    far = np.linalg.norm(points[chosen] - np.median(points[chosen], axis=0), axis=1) if len(chosen) else np.empty(0)
    chosen = chosen[far <= np.percentile(far, 97)] if len(chosen) else chosen
    grey = np.repeat(a["map/grey"][chosen, None], 3, axis=1)
    known = np.isfinite(a["world_from_rig"]).all(axis=(1, 2))
    parts = [(points[chosen], grey), _painted(_dense(a["world_from_rig"][known, :3, 3]), PATH_COLOUR)]
    legend = {"map": (128, 128, 128), "path of the head": PATH_COLOUR}
    about = "What was seen, and from where"
    if "por/points" in a:
        parts.append(_painted(a["por/points"][a["por/outcome"] == "hit"], POR_COLOUR))
        legend["points of regard"] = POR_COLOUR
        about = "What was seen, from where, and what was looked at"
    places = np.concatenate([part for part, _ in parts]) @ turntable.UPRIGHT
    scene = turntable.cloud_scene(places, np.concatenate([colours for _, colours in parts]))
    about += "; first seen from behind the first picture."
    start = turntable.looking_from(places, np.array([0.0, 0.35, 1.0]))
    atomic.write_text(path, turntable.turning_page(scene, title, about, legend, from_camera=start))


def _dense(path: np.ndarray, times: int = 12) -> np.ndarray:
    """Points along a path between its corners."""
    share = np.linspace(0, 1, times, endpoint=False)[:, None, None]
    return np.concatenate([((1 - share) * path[:-1] + share * path[1:]).reshape(-1, 3), path[-1:]])
