"""KITTI stereo 2012: rectified stereo pairs, calibration, LIDAR truth, and poses of the multi-view bundles.

Layout: ``image_0/000027_10.png`` (left) and ``image_1`` (right), or ``colored_0`` and ``colored_1``;
``calib/000027.txt``; ``disp_noc/000027_10.png`` and ``disp_occ`` with disparity * 256 as 16-bit PNG. Geiger, Lenz,
Urtasun: Are we ready for autonomous driving? (CVPR 2012).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import npz
from ipcli.io.files.images import read_depth, read_image
from ipcli.io.files.text import comment_free, numbers, require_folder

TRUTH_FRAME = "10"  # the only frame of a scene with ground truth
CAMERAS = {"image_0": ("P0", "P1"), "colored_0": ("P2", "P3")}  # left folder -> names of the two projection matrices
DISPARITY_SCALE = 256.0


@dataclass(frozen=True, eq=False)
class Calibration:
    """A rectified pair: shared intrinsics, and the shifts against camera 0, in which the poses are given."""

    intrinsics: np.ndarray  # (3, 3)
    left_from_cam0: np.ndarray  # (4, 4)
    right_from_cam0: np.ndarray  # (4, 4)

    @property
    def baseline_focal(self) -> float:
        """Pixels times metres: depth = baseline_focal / disparity."""
        return float(self.intrinsics[0, 0] * (self.left_from_cam0[0, 3] - self.right_from_cam0[0, 3]))


def left_folder(folder: Path) -> Path:
    """``image_0`` or ``colored_0``, whichever is there (gray first)."""
    for name in CAMERAS:
        if (folder / name).is_dir():
            return folder / name
    raise FormatError(
        require_folder(folder),
        "not a KITTI stereo folder",
        expected="image_0/ or colored_0/",
        fix="Give the training folder",
    )


def right_folder(folder: Path) -> Path:
    """The folder of the right camera that goes with ``left_folder``."""
    left = left_folder(folder)
    return left.with_name(left.name[:-1] + "1")


def scenes(folder: Path) -> tuple[str, ...]:
    """Names such as ``000027``, in order."""
    return tuple(sorted({path.stem.rpartition("_")[0] for path in left_folder(folder).glob("*_*.png")}))


def frames(folder: Path, scene: str) -> tuple[str, ...]:
    """Frame numbers of a scene, such as ``10``, that both cameras have; FormatError when there is none."""
    left = {path.name for path in left_folder(folder).glob(f"{scene}_*.png")}
    both = sorted(left & {path.name for path in right_folder(folder).glob(f"{scene}_*.png")})
    if not both:
        raise FormatError(
            left_folder(folder),
            f"no stereo pair of scene {scene!r}",
            expected=f"{scene}_10.png for both cameras",
            fix=f"Scenes here: {', '.join(scenes(folder)) or 'none'}",
        )
    return tuple(Path(name).stem.rpartition("_")[2] for name in both)


def pair_files(folder: Path, scene: str, frame: str) -> tuple[Path, Path]:
    """Paths of the left and the right image."""
    return left_folder(folder) / f"{scene}_{frame}.png", right_folder(folder) / f"{scene}_{frame}.png"


def calibration_file(folder: Path, scene: str) -> Path:
    """Path of the projection matrices of a scene."""
    return folder / "calib" / f"{scene}.txt"


def truth_file(folder: Path, scene: str, occluded: bool) -> Path:
    """Path of the true disparities, with or without those pixels that the right camera does not see."""
    return folder / ("disp_occ" if occluded else "disp_noc") / f"{scene}_{TRUTH_FRAME}.png"


def pair(folder: Path, scene: str, frame: str) -> tuple[np.ndarray, np.ndarray]:
    """Left and right image, (h, w, 3) uint8 each."""
    left, right = (read_image(path) for path in pair_files(folder, scene, frame))
    if left.shape != right.shape:
        raise FormatError(
            pair_files(folder, scene, frame)[1],
            "right image differs in size from the left",
            expected=left.shape,
            got=right.shape,
            fix="Use the rectified images",
        )
    return left, right


def truth(folder: Path, scene: str, occluded: bool = False) -> np.ndarray:
    """True disparity (h, w) float32 in pixels of frame 10 of the left camera, NaN where the LIDAR saw nothing."""
    return read_depth(truth_file(folder, scene, occluded), DISPARITY_SCALE)


def calibration(folder: Path, scene: str) -> Calibration:
    """Camera of a scene. P_i = K [I | t_i], so t_i = K^-1 P_i[:, 3] is the shift cam_i_from_cam0."""
    path = calibration_file(folder, scene)
    matrices = {}
    for line, text in comment_free(path):
        name, _, values = text.partition(":")
        if name.startswith("P"):
            matrices[name] = numbers(path, line, values.split(), [12]).reshape(3, 4)
    wanted = CAMERAS[left_folder(folder).name]
    if missing := [name for name in wanted if name not in matrices]:
        raise FormatError(
            path,
            f"no projection matrix {missing[0]}",
            expected=" and ".join(wanted),
            got=", ".join(matrices) or "none",
            fix="Give the calibration file of the rectified images",
        )
    left, right = (matrices[name] for name in wanted)
    if not np.isfinite([left, right]).all() or min(left[0, 0], left[1, 1], right[0, 0], right[1, 1]) <= 0:
        raise FormatError(path, "no projection matrices", expected="finite numbers and focal lengths > 0")
    camera = Calibration(left[:, :3], _shift(left), _shift(right))
    if camera.baseline_focal <= 0:
        raise FormatError(
            path,
            "baseline is not positive",
            expected=f"{wanted[1]} to the right of {wanted[0]}",
            got=f"{camera.baseline_focal:g} pixels * metres",
            fix="Swap the cameras",
        )
    return camera


def _shift(projection: np.ndarray) -> np.ndarray:
    shift = np.eye(4)
    shift[:3, 3] = np.linalg.solve(projection[:, :3], projection[:, 3])
    return shift


def poses_file(path: Path, scene: str) -> Path:
    """The file that ``poses`` reads: ``path``, or that of the scene in it when it is a folder."""
    return path / f"{scene}.txt" if path.is_dir() else path


def poses(path: Path, scene: str, method: str = "viso") -> dict[str, np.ndarray]:
    """world_from_cam0 (4, 4) by frame number as in file names (``07``), of the frames of a scene that have a pose.

    ``path`` is the NPZ with one array (scenes, frames, 4, 4) a ``method``, NaN where a pose is unknown, or a text file
    of one scene in the form of KITTI odometry (12 numbers a line, the line number being the frame), or a folder of such
    files named after the scenes.
    """
    path = poses_file(path, scene)
    matrices = _poses_npz(path, scene, method) if path.suffix == ".npz" else _poses_text(path)
    return {f"{frame:02d}": pose for frame, pose in enumerate(matrices) if np.isfinite(pose).all()}


def _poses_npz(path: Path, scene: str, method: str) -> np.ndarray:
    arrays = npz.read(path)
    if method not in arrays:
        raise FormatError(
            path, f"no poses by {method!r}", expected=f"one of {', '.join(arrays)}", fix="Choose another method"
        )
    table = arrays[method]
    if table.ndim != 4 or table.shape[2:] != (4, 4):
        raise FormatError(
            path,
            f"{method!r} is not a table of poses",
            expected="(scenes, frames, 4, 4)",
            got=table.shape,
            fix="Check the file",
        )
    if not scene.isdecimal() or int(scene) >= len(table):
        raise FormatError(
            path, f"no poses of scene {scene!r}", expected=f"a number below {len(table)}", fix="Leave that scene out"
        )
    return table[int(scene)]


def _poses_text(path: Path) -> np.ndarray:
    rows = [numbers(path, line, text.split(), [12]).reshape(3, 4) for line, text in comment_free(path)]
    last = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(rows), 1, 4))
    return np.concatenate([np.reshape(rows, (-1, 3, 4)), last], axis=1)
