"""Posed recordings as subsequences: a `gaze-experiment` of gaze-sfm, or any views with depth."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.geometry import lie
from ipcli.geometry.cameras import back_project
from ipcli.io.files import h5, ply
from ipcli.io.views import layouts
from ipcli.measurements.recording import Camera
from ipcli.measurements.subsequences import PosedSequence, Snapshot, Subsequence
from ipcli.measurements.views import Views

SHOTS = 3  # pictures of a subsequence that are looked at
LONGEST = 15  # frames of a subsequence where gaze does not make them, as in the thesis
CLOUD = 40_000  # points of a subsequence that depth maps are thinned to
WIDEST = 480  # pixels of a picture of views
FLAT = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".ply", ".obj", ".glb", ".stl", ".off")
WANTED = (
    "world_from_rig", "times", "map/points", "map/sightings", "pictures", "picture_frames", "subsequences/frames",
    "por/points", "por/outcome", "por/frame",
)  # fmt: skip


def open_posed(path: Path, format: str = "auto") -> PosedSequence:
    """The recording at `path`: an experiment of gaze-sfm, or whatever fuse-depth takes.

    Raises FormatError for anything else, or for an experiment without a pose or a picture.
    """
    path = Path(path)
    if path.suffix.lower() in FLAT and path.is_file():
        raise FormatError(
            path, "a picture or mesh, not a recording", fix="saliency predict tells of pictures and meshes"
        )
    if path.suffix.lower() in (".h5", ".hdf5") and path.is_file() and h5.peek(path).kind == "gaze-experiment":
        return read_experiment(path)
    return of_views(path, layouts.open_views(path, format))


def read_experiment(path: Path) -> PosedSequence:
    """The coherent subsequences of a `gaze-experiment`."""
    a = h5.read(path, "gaze-experiment", only=lambda name: name in WANTED or name.startswith("rig/")).arrays
    posed = np.isfinite(a["world_from_rig"]).all(axis=(1, 2))
    kept = np.array([n for n, frame in enumerate(a["picture_frames"]) if posed[frame]], int)
    spans = [span for span in a["subsequences/frames"] if posed[span[0] : span[1]].any()]
    if not len(kept) or not spans:
        raise FormatError(
            path, "no frame has both a picture and a pose", fix="Run gaze-sfm on a recording it can follow"
        )
    cam_from_world = lie.se3_inverse(a["world_from_rig"])
    hit = a["por/outcome"] == "hit" if "por/outcome" in a else np.zeros(0, bool)
    regards = a["por/points"][hit] if hit.size else np.empty((0, 3))
    frames = a["por/frame"][hit] if hit.size else np.empty(0, np.int64)

    def load(number: int) -> Subsequence:
        first, stop = (int(frame) for frame in spans[number])
        reference = _middle(np.flatnonzero(posed[first:stop]) + first)
        sightings = a["map/sightings"]
        seen = np.unique(sightings[(sightings[:, 0] >= first) & (sightings[:, 0] < stop), 2])
        own = kept[(a["picture_frames"][kept] >= first) & (a["picture_frames"][kept] < stop)]
        if not len(own):
            own = kept[[np.abs(a["picture_frames"][kept] - reference).argmin()]]
        shots = [
            Snapshot(int(a["picture_frames"][n]), a["pictures"][n], cam_from_world[a["picture_frames"][n]])
            for n in own[np.unique(np.linspace(0, len(own) - 1, SHOTS).astype(int))]
        ]
        mine = regards[(frames >= first) & (frames < stop)]
        times = (float(a["times"][first]), float(a["times"][stop - 1]))
        return Subsequence(
            number, (first, stop), times, a["map/points"][seen], cam_from_world[reference], tuple(shots), mine
        )

    camera = _at_size(a, (a["pictures"].shape[2], a["pictures"].shape[1]))
    return PosedSequence(len(spans), load, camera, (path,), regards, frames, "gaze-experiment")


def read_cloud(path: Path) -> np.ndarray:
    """Points (n, 3) of a `fusion-cloud` or a PLY. Raises FormatError for anything else."""
    if path.suffix.lower() == ".ply":
        return ply.read(path).vertices.astype(np.float64)
    return h5.read(path, "fusion-cloud", only=lambda name: name == "points").arrays["points"].astype(np.float64)


def _middle(values: np.ndarray) -> int:
    return int(values[(len(values) - 1) // 2])


def _at_size(a: dict[str, np.ndarray], size: tuple[int, int]) -> Camera:
    """Camera 0 of the rig for pictures of another size."""
    k = a["rig/intrinsics"][0].copy()
    scale = np.array(size) / a["rig/sizes"][0]
    k[[0, 1], [0, 1]] *= scale
    k[:2, 2] = (k[:2, 2] + 0.5) * scale - 0.5
    distortion = a["rig/distortion"][0]
    return Camera(size, k, str(a["rig/models"][0]), distortion[np.isfinite(distortion)])


def of_views(path: Path, views: Views) -> PosedSequence:
    """Views with depth as runs of frames that follow each other; no gaze, and frame numbers for seconds."""
    if not views.names:
        raise FormatError(path, "no views", fix="Give views with depth and poses")
    first = views.load(views.names[0])
    if first.image is None:
        raise FormatError(path, f"view '{views.names[0]}' has no picture", fix="Give views with pictures")
    thinning = max(1, -(-first.image.shape[1] // WIDEST))
    camera = _thinned_camera(first.intrinsics, first.image.shape, thinning)
    spans = [(start, min(start + LONGEST, len(views.names))) for start in range(0, len(views.names), LONGEST)]

    def load(number: int) -> Subsequence:
        start, stop = spans[number]
        clouds, shots, poses = [], [], {}
        chosen = set(np.linspace(start, stop - 1, SHOTS).astype(int).tolist())
        each = max(CLOUD // (stop - start), 100)
        for k in range(start, stop):
            view = views.load(views.names[k], pictures=k in chosen)
            poses[k] = view.cam_from_world
            clouds.append(_cloud(view.depth, view.intrinsics, view.cam_from_world, each))
            if view.image is not None and k in chosen:
                image = np.ascontiguousarray(view.image[::thinning, ::thinning])
                shots.append(Snapshot(k, image, view.cam_from_world))
        reference = poses[(start + stop - 1) // 2]
        return Subsequence(
            number, (start, stop), (float(start), float(stop - 1)), np.concatenate(clouds), reference, tuple(shots)
        )

    files = tuple(dict.fromkeys(file for name in views.names for file in views.files(name)))
    notes = (f"no clock in {path.name}: times are numbers of frames",)
    return PosedSequence(len(spans), load, camera, files, np.empty((0, 3)), np.empty(0, np.int64), "views", notes)


def _thinned_camera(intrinsics: np.ndarray, shape: tuple[int, ...], thinning: int) -> Camera:
    k = intrinsics.astype(np.float64).copy()
    k[:2] /= thinning
    return Camera((-(-shape[1] // thinning), -(-shape[0] // thinning)), k)


def _cloud(depth: np.ndarray, intrinsics: np.ndarray, cam_from_world: np.ndarray, most: int) -> np.ndarray:
    points = back_project(depth, intrinsics).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    points = points[:: max(1, len(points) // most)]
    world_from_cam = lie.se3_inverse(cam_from_world[None])[0]
    return points @ world_from_cam[:3, :3].T + world_from_cam[:3, 3]
