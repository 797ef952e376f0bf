"""A folder of surfaces that were looked at in virtual reality: NAME.npz with xyz, normal and fix_time of each vertex.

That is the set of 3D_Mesh_Saliency_Prediction (Martin, Fandos et al.) as arrays; its `label` says which 5 % of the
vertices count as looked at, and without it those are the 5 % of the longest times. Triangles may be added as `faces`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import npz
from ipcli.measurements.fixations import FixatedSurface, FixationSet

FEWEST = 100  # vertices
SHARE = 0.05  # of the vertices that count as looked at where no label says


def is_surface_set(path: Path) -> bool:
    """Whether the folder holds NAME.npz files, and the first of them times of fixation."""
    files = sorted(path.glob("*.npz")) if path.is_dir() else []
    return bool(files) and _holds_times(files[0])


def _holds_times(file: Path) -> bool:
    try:
        return {"xyz", "fix_time"} <= npz.read(file).keys()
    except FormatError:
        return False


def open_surface_set(path: Path) -> FixationSet:
    """All surfaces of the folder in order of their names. Raises FormatError."""
    return FixationSet(surfaces=tuple(_surface(file) for file in sorted(path.glob("*.npz"))))


def _surface(file: Path) -> FixatedSurface:
    arrays = npz.read(file)
    if missing := [name for name in ("xyz", "normal", "fix_time") if name not in arrays]:
        raise FormatError(file, f"holds no '{missing[0]}'", expected="xyz, normal, fix_time", got=", ".join(arrays))
    vertices, normals, times = (np.asarray(arrays[name], np.float64) for name in ("xyz", "normal", "fix_time"))
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < FEWEST:
        raise FormatError(file, "xyz: wrong shape", expected=f"(n, 3) with n >= {FEWEST}", got=vertices.shape)
    if normals.shape != vertices.shape or times.shape != vertices.shape[:1]:
        raise FormatError(file, "xyz, normal and fix_time do not agree", got=f"{normals.shape}, {times.shape}")
    if not all(np.isfinite(part).all() for part in (vertices, normals, times)) or times.min() < 0:
        raise FormatError(file, "numbers that are not finite, or times below 0")
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0, normals / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])
    looked_at = _looked_at(file, times, arrays.get("label"))
    return FixatedSurface(file.stem, vertices, normals, times, looked_at, arrays.get("faces"))


def _looked_at(file: Path, times: np.ndarray, label: np.ndarray | None) -> np.ndarray:
    """Which vertices (n,) count as looked at."""
    if label is not None and np.shape(label) != times.shape:
        raise FormatError(file, "label: wrong shape", expected=times.shape, got=np.shape(label))
    looked_at = times > max(float(np.quantile(times, 1 - SHARE)), 0.0) if label is None else np.asarray(label) > 0
    if not looked_at.any():
        raise FormatError(file, "no vertex was looked at")
    return looked_at
