"""Views as an HDF5 artefact, read view by view."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ipcli.io.files import h5
from ipcli.measurements.names import natural
from ipcli.measurements.views import View, Views, check_view

PICTURES = ("image", "truth")
PER_VIEW = ("depth", "intrinsics", "cam_from_world", "confidence", *PICTURES)


def read_views(path: Path) -> Views:
    """The sequence in a `views` artefact."""
    fields = h5.names(path)
    shared = h5.read(path, "views", only=lambda field: not field.startswith("views/")).arrays
    names = tuple(sorted({field.split("/")[1] for field in fields if field.startswith("views/")}, key=natural))
    baseline_focal = float(shared["baseline_focal"]) if "baseline_focal" in shared else None

    def load(name: str, pictures: bool = True) -> View:
        prefix = f"views/{name}/"
        wanted = [prefix + field for field in PER_VIEW if pictures or field not in PICTURES]
        arrays = h5.read(path, "views", only=lambda field: field in wanted).arrays
        return check_view(View(name, **{field.removeprefix(prefix): array for field, array in arrays.items()}), path)

    return Views(names, str(shared["unit"]), str(shared["measured"]), baseline_focal, load, lambda name: (path,))


def views_arrays(
    views: Iterable[View], *, unit: str, measured: str, baseline_focal: float | None = None
) -> dict[str, np.ndarray]:
    """The fields of a `views` artefact that holds these views."""
    arrays: dict[str, np.ndarray] = {"unit": np.array(unit), "measured": np.array(measured)}
    if baseline_focal is not None:
        arrays["baseline_focal"] = np.array(baseline_focal, dtype=np.float64)
    for view in views:
        for field in PER_VIEW:
            if (array := getattr(view, field)) is not None:
                arrays[f"views/{view.name}/{field}"] = np.ascontiguousarray(array)
    return arrays
