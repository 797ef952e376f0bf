"""Head paths on the same frames in one run: gaze-sfm beside pycolmap's incremental mapping with the rig held fixed.

    python -m benchmarks.gaze.paths --recording ../shared/data/gaze/euroc_v101_sub100 --frames 30
    python -m benchmarks.gaze.paths --recording ../shared/data/gaze/boofcv_library346 --alone --threads 2
    python -m benchmarks.gaze.paths --quick

Each row is a process of its own; see README.md for what the table says.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import add_threads, parser_of
from benchmarks.kit.measure import Clock, attempted, forget_peak, installed, peak_memory
from benchmarks.kit.publish import publish
from ipcli.measurements.recording import HeadRecording

PINHOLE = 8  # distortion coefficients of COLMAP's FULL_OPENCV
OVERLAP = 10  # frames that pycolmap matches each frame with
SIDES = ("left", "right")


def opened(recording: str, frames: int) -> HeadRecording:
    """The first frames of a recording."""
    from ipcli.stages.gaze.parameters import RecordingSource
    from ipcli.stages.gaze.sources import open_source

    return open_source(Path(recording), RecordingSource(stop=frames))


def ours(recording: str, frames: int) -> dict[str, Any]:
    """gaze-sfm's localisation with its defaults."""
    from ipcli.geometry import lie
    from ipcli.models.gaze.localise import localise
    from ipcli.models.gaze.parameters import Localisation

    found = opened(recording, frames)
    localise(opened(recording, 3), Localisation(), 0)  # kernels compiled
    start, clock = forget_peak(), Clock()
    with clock:
        path = localise(found, Localisation(), 0)
    return _row(found, lie.se3_inverse(np.stack([track.pose for track in path.tracks])), clock, peak_memory() - start)


def pycolmap_rig(recording: str, frames: int) -> dict[str, Any]:
    """SIFT with as many features, sequential matching, incremental mapping under the fixed rig."""
    import pycolmap

    found = opened(recording, frames)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        _pictures(found, folder)
        start, clock = forget_peak(), Clock()
        with clock:
            models = _mapped(pycolmap, found, folder)
        peak = peak_memory() - start
        poses = np.full((len(found.names), 4, 4), np.nan)
        for image in max(models.values(), key=lambda model: model.num_reg_images()).images.values():
            if image.name.startswith(SIDES[0]) and image.has_pose:
                pose = np.eye(4)
                pose[:3] = image.cam_from_world().matrix()
                poses[int(Path(image.name).stem)] = np.linalg.inv(pose)
    return _row(found, poses, clock, peak)


def _mapped(pycolmap: Any, found: HeadRecording, folder: Path) -> dict[int, Any]:
    """Reconstructions by number."""
    database, pictures = folder / "database.db", folder / "pictures"
    for side, camera in zip(SIDES, found.cameras, strict=True):
        k, lens = camera.intrinsics, np.zeros(PINHOLE)
        lens[: len(camera.distortion)] = camera.distortion
        values = (k[0, 0], k[1, 1], k[0, 2] + 0.5, k[1, 2] + 0.5, *lens)
        reader = pycolmap.ImageReaderOptions(
            camera_model="FULL_OPENCV", camera_params=",".join(f"{value:.12g}" for value in values)
        )
        options = pycolmap.FeatureExtractionOptions(use_gpu=False, num_threads=_threads())
        options.sift.max_num_features = 1500
        names = [f"{side}/{k:05d}.png" for k in range(len(found.names))]
        pycolmap.extract_features(
            database, pictures, image_names=names, camera_mode=pycolmap.CameraMode.PER_FOLDER, reader_options=reader,
            extraction_options=options,
        )  # fmt: skip
    right = found.cameras[1].cam_from_rig
    turned = pycolmap.Rigid3d(pycolmap.Rotation3d(right[:3, :3]), right[:3, 3])
    rig = pycolmap.RigConfig(
        cameras=[
            pycolmap.RigConfigCamera(ref_sensor=True, image_prefix=f"{SIDES[0]}/"),
            pycolmap.RigConfigCamera(image_prefix=f"{SIDES[1]}/", cam_from_rig=turned),
        ]
    )
    with pycolmap.Database.open(database) as opened_database:
        pycolmap.apply_rig_config([rig], opened_database)
    pycolmap.match_sequential(
        database,
        pairing_options=pycolmap.SequentialPairingOptions(overlap=OVERLAP, quadratic_overlap=False),
        matching_options=pycolmap.FeatureMatchingOptions(use_gpu=False, num_threads=_threads()),
    )
    options = pycolmap.IncrementalPipelineOptions(
        ba_refine_sensor_from_rig=False, ba_refine_focal_length=False, ba_refine_principal_point=False,
        ba_refine_extra_params=False, num_threads=_threads(),
    )  # fmt: skip
    options.mapper.init_min_tri_angle = 2.0  # forward motion finds no first pair otherwise
    options.mapper.init_max_forward_motion = 1.0
    (folder / "model").mkdir()
    return dict(pycolmap.incremental_mapping(database, pictures, folder / "model", options))


def _pictures(found: HeadRecording, folder: Path) -> None:
    from ipcli.io.files.images import encode_png

    for side in SIDES:
        (folder / "pictures" / side).mkdir(parents=True)
    for k in range(len(found.names)):
        frame = found.load(k)
        for side in SIDES:
            (folder / "pictures" / side / f"{k:05d}.png").write_bytes(encode_png(getattr(frame, side)))


def _threads() -> int:
    return int(os.environ.get("OMP_NUM_THREADS", "1"))


def _row(found: HeadRecording, poses: np.ndarray, clock: Clock, peak: float) -> dict[str, Any]:
    from ipcli.models.gaze.evaluation import path_errors

    truth = np.full_like(poses, np.nan) if found.truth is None else found.truth
    errors = path_errors(poses, truth)
    return {
        "frames": len(poses),
        "posed": int(np.isfinite(poses).all(axis=(1, 2)).sum()),
        "error [m]": errors.rigid.rmse,
        "with scale [m]": errors.similar.rmse,
        "scale": errors.similar.scale,
        "seconds": clock.last,
        "CPU s": clock.processor,
        "MB": peak,
        "CPU s a frame": clock.processor / len(poses),
    }


def generated(folder: Path) -> Path:
    """A small room, for a quick look."""
    from experiments.gaze import room

    room.write_euroc(room.walk(room.Course(frames=16, rate=5.0, width=320, height=240, gaze_rate=5.0), 3), folder)
    return folder


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write and print."""
    parser = parser_of(__doc__, "a small generated room")
    parser.add_argument("--recording", type=Path, help="folder of any layout that gaze-sfm reads")
    parser.add_argument("--frames", type=int, default=0, help="first frames of it to take; all")
    parser.add_argument("--alone", action="store_true", help="without pycolmap, whose time grows with the square")
    add_threads(parser)
    given = parser.parse_args(arguments)
    if not given.quick and given.recording is None:
        parser.error("give --recording or --quick")
    with tempfile.TemporaryDirectory() as place:
        recording = generated(Path(place)) if given.recording is None else given.recording.resolve()
        case = {"recording": str(recording), "frames": given.frames}
        rows = [{"method": "gaze-sfm"} | attempted("benchmarks.gaze.paths:ours", given.threads, **case)]
        if not given.alone and installed("pycolmap", "pycolmap"):
            peer = attempted("benchmarks.gaze.paths:pycolmap_rig", given.threads, **case)
            rows.append({"method": "pycolmap, rig fixed"} | peer)
    facts = {"recording": "generated" if given.recording is None else given.recording.name, "threads": given.threads}
    publish("gaze_paths", "Head paths", {"The same frames": rows}, facts, given.output)


if __name__ == "__main__":
    main()
