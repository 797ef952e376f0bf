"""Trajectories: TUM and KITTI text files, and poses taken at other times by interpolation on SE(3)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.inputs import warn_if_cut
from ipcli.io.files import text as layout

UNIT = 0.01  # how far a quaternion's length may be from 1


def read_tum(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and world_from_cam (n, 4, 4) of lines `time tx ty tz qx qy qz qw`, in order of time."""
    from scipy.spatial.transform import Rotation

    warn_if_cut(path, layout.read_text(path))
    rows = [layout.numbers(path, line, text.replace(",", " ").split(), [8]) for line, text in layout.comment_free(path)]
    table = np.array(rows).reshape(-1, 8)
    if not len(table) or not np.isfinite(table).all():
        raise FormatError(path, "no trajectory", expected="lines of 8 finite numbers", got=f"{len(table)} lines")
    lengths = np.linalg.norm(table[:, 4:], axis=1)
    if np.abs(lengths - 1).max() > UNIT:
        raise FormatError(
            path, "quaternions are not of unit length", got=f"{lengths.min():.3g} to {lengths.max():.3g}",
            fix="Order: time tx ty tz qx qy qz qw",
        )  # fmt: skip
    order = np.argsort(table[:, 0], kind="stable")
    if (np.diff(table[order, 0]) == 0).any():
        raise FormatError(path, "one time twice", fix="Leave one of the two lines out")
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(table[order, 4:]).as_matrix()
    poses[:, :3, 3] = table[order, 1:4]
    return table[order, 0], poses


def write_tum(times: np.ndarray, world_from_cam: np.ndarray, comment: str) -> str:
    """The text of a TUM trajectory; poses with NaN are left out."""
    from scipy.spatial.transform import Rotation

    lines = [f"# {comment}", "# time tx ty tz qx qy qz qw"]
    for time, pose in zip(times, world_from_cam, strict=True):
        if np.isfinite(pose).all():
            quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat()
            lines.append(" ".join([f"{time:.9f}", *(f"{value:.9f}" for value in (*pose[:3, 3], *quaternion))]))
    return "\n".join(lines) + "\n"


def read_kitti(path: Path, count: int) -> np.ndarray:
    """world_from_cam (count, 4, 4) of lines of 12 numbers."""
    warn_if_cut(path, layout.read_text(path))
    rows = [layout.numbers(path, line, text.split(), [12]) for line, text in layout.comment_free(path)]
    if len(rows) != count:
        raise FormatError(
            path, "not one pose a frame", expected=count, got=len(rows), fix="Give the poses of these frames"
        )
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3] = np.array(rows).reshape(-1, 3, 4)
    if not np.allclose(poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2), np.eye(3), atol=1e-3):
        raise FormatError(path, "poses are not rigid", fix="Give rows of [R | t], world from camera")
    return poses


def at_times(times: np.ndarray, poses: np.ndarray, wanted: np.ndarray, gap: float) -> np.ndarray:
    """Poses (n, 4, 4) at the wanted times, between neighbours at most `gap` s apart; NaN elsewhere."""
    from scipy.spatial.transform import Rotation

    found = np.full((len(wanted), 4, 4), np.nan)
    right = np.clip(np.searchsorted(times, wanted), 1, max(len(times) - 1, 1))
    left = right - 1
    if len(times) < 2:
        near = np.abs(wanted - times[0]) < 1e-6
        found[near] = poses[0]
        return found
    share = (wanted - times[left]) / (times[right] - times[left])
    known = (share >= -1e-6) & (share <= 1 + 1e-6) & (times[right] - times[left] <= gap)
    known |= np.minimum(np.abs(wanted - times[left]), np.abs(wanted - times[right])) < 1e-4
    share, left, right = np.clip(share[known], 0, 1), left[known], right[known]
    first = Rotation.from_matrix(poses[left, :3, :3])
    turn = (first.inv() * Rotation.from_matrix(poses[right, :3, :3])).as_rotvec()
    found[known] = np.eye(4)
    found[known, :3, :3] = (first * Rotation.from_rotvec(share[:, None] * turn)).as_matrix()
    found[known, :3, 3] = (1 - share[:, None]) * poses[left, :3, 3] + share[:, None] * poses[right, :3, 3]
    return found
