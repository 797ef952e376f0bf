"""Depth maps with their cameras, and sequences of them that are read one by one.

`cam_from_world` maps world points into the camera; the conventions of cameras are those of `ipcli.geometry.cameras`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from ipcli.errors import FormatError

# largest |R^T R - I| entry: poses printed with four decimals pass, a scaled or sheared one does not
RIGID_TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
class View:
    """One depth map with its camera. Depth and truth are in the unit of the scene, NaN where nothing is known."""

    name: str
    depth: np.ndarray  # (h, w) float32, NaN = no data
    intrinsics: np.ndarray  # (3, 3) float64, pixels
    cam_from_world: np.ndarray  # (4, 4) float64, rigid
    confidence: np.ndarray | None = None  # (h, w) float32 in [0, inf)
    image: np.ndarray | None = None  # (h, w, 3) uint8 RGB
    truth: np.ndarray | None = None  # (h, w) float32, NaN = unknown


class Loader(Protocol):
    """How a sequence reads a view."""

    def __call__(self, name: str, pictures: bool = True) -> View:
        """The view of that name; without pictures its image and truth are left unread."""


@dataclass(frozen=True)
class Views:
    """Views in order, each read only when asked for: a long recording costs the memory of the views in use."""

    names: tuple[str, ...]
    unit: str  # of depth and translation, such as "m"
    measured: str  # the quantity whose noise is homogeneous: "depth" or "disparity"
    baseline_focal: float | None  # pixels * unit: disparity = baseline_focal / depth
    load: Loader
    files: Callable[[str], tuple[Path, ...]]  # the files a view is made of, for the provenance
    notes: tuple[str, ...] = ()  # what a user should know of the source: items left out, and why

    def __repr__(self) -> str:
        ends = " ... ".join(repr(name) for name in dict.fromkeys((self.names[0], self.names[-1]))) if self.names else ""
        return f"Views({len(self.names)}: {ends}; {self.measured} in {self.unit})"


def relative(dst: View, src: View) -> np.ndarray:
    """The rigid motion dst_from_src (4, 4) between the camera frames of two views."""
    return dst.cam_from_world @ np.linalg.inv(src.cam_from_world)


def check_view(view: View, where: str | Path | None = None) -> View:
    """Return the view if it is sound, else raise FormatError naming the view, what is wrong with it and what to do.

    Asked for: a 2-D depth map with values > 0 or NaN; confidence, image and truth on the same pixels; an upper
    triangular intrinsic matrix with positive focal lengths; a rigid ``cam_from_world`` (R^T R = I to 1e-3, det R > 0,
    last row 0 0 0 1). ``where`` is the file or folder the view was read from.
    """
    at = f"view {view.name!r}" if where is None else f"{where}: view {view.name!r}"
    _check_depth(at, "depth", view.depth)
    _check_companions(at, view)
    _check_intrinsics(at, view.intrinsics)
    _check_pose(at, view.cam_from_world)
    return view


def _check_depth(at: str, field: str, depth: np.ndarray) -> None:
    if depth.ndim != 2 or depth.size == 0:
        raise FormatError(
            at, f"{field} is not an image", expected="shape (h, w)", got=depth.shape, fix="Give one channel"
        )
    bad = (depth <= 0) | np.isinf(depth)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise FormatError(
            at,
            f"{np.count_nonzero(bad)} {field} values are not positive and finite",
            expected="> 0, NaN = no data",
            got=f"{depth[row, column]} at row {row}, column {column}",
            fix="Mark missing depth as NaN",
        )


def _check_companions(at: str, view: View) -> None:
    shape = view.depth.shape
    wanted = {"confidence": shape, "image": (*shape, 3), "truth": shape}
    for field, expected in wanted.items():
        array = getattr(view, field)
        if array is not None and array.shape != expected:
            raise FormatError(
                at,
                f"{field} does not cover the depth map",
                expected=expected,
                got=array.shape,
                fix=f"Resample the {field} to the size of the depth map, or leave it out",
            )
    if view.truth is not None:
        _check_depth(at, "truth", view.truth)
    if view.confidence is not None and not (np.isfinite(view.confidence) & (view.confidence >= 0)).all():
        raise FormatError(at, "confidence is not a finite number >= 0 everywhere", fix="Give 0 where nothing is known")


def _check_intrinsics(at: str, intrinsics: np.ndarray) -> None:
    if intrinsics.shape != (3, 3):
        raise FormatError(
            at,
            "intrinsics have the wrong shape",
            expected=(3, 3),
            got=intrinsics.shape,
            fix="Give [fx 0 cx; 0 fy cy; 0 0 1]",
        )
    below = intrinsics[[1, 2, 2, 2], [0, 0, 1, 2]]
    if not np.isfinite(intrinsics).all() or not np.allclose(below, (0, 0, 0, 1)):
        raise FormatError(
            at,
            "intrinsics are not a camera matrix",
            expected="[fx s cx; 0 fy cy; 0 0 1]",
            got=intrinsics.tolist(),
            fix="Scale the last row to 0 0 1 and check that the matrix is not transposed",
        )
    if intrinsics[0, 0] <= 0 or intrinsics[1, 1] <= 0:
        raise FormatError(
            at,
            "focal length is not positive",
            expected="fx, fy > 0 pixels",
            got=tuple(np.diag(intrinsics)[:2].tolist()),
            fix="Flip the axes of the pose, not the focal length (y down, z forward)",
        )


def _check_pose(at: str, pose: np.ndarray) -> None:
    if pose.shape != (4, 4):
        raise FormatError(
            at, "pose has the wrong shape", expected=(4, 4), got=pose.shape, fix="Add the last row 0 0 0 1"
        )
    if not np.isfinite(pose).all():
        raise FormatError(at, "pose holds NaN or inf", fix="Leave out the views whose pose is unknown")
    if not np.allclose(pose[3], (0, 0, 0, 1)):
        raise FormatError(
            at,
            "pose has a wrong last row",
            expected="0 0 0 1",
            got=pose[3].tolist(),
            fix="Check that it is not transposed",
        )
    rotation = pose[:3, :3]
    deviation = np.abs(rotation.T @ rotation - np.eye(3)).max()
    if deviation > RIGID_TOLERANCE:
        raise FormatError(
            at,
            "pose is not rigid",
            expected=f"|R^T R - I| <= {RIGID_TOLERANCE:g}",
            got=f"{deviation:.3g}",
            fix="Take the scale out of the rotation and check the order of the numbers",
        )
    if np.linalg.det(rotation) < 0:
        raise FormatError(
            at, "pose mirrors the scene", expected="det R = 1", got="det R = -1", fix="Use a right-handed camera frame"
        )
