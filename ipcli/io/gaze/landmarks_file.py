"""Landmarks from a table: their places, and optionally where pictures show them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.gaze.gaze_files import columns_of, places_of
from ipcli.measurements.recording import Landmarks

MARK = ("frame", "u [px]", "v [px]")


def read_landmarks(path: Path) -> Landmarks:
    """A table `name, x [m], y [m], z [m]`, with `frame, u [px], v [px]` a line a mark. Raises FormatError."""
    columns = columns_of(path)
    names, places = places_of(path, columns, "landmark")
    unique = tuple(dict.fromkeys(names))
    first = [names.index(name) for name in unique]
    number = {name: i for i, name in enumerate(unique)}
    for name, place in zip(names, places, strict=True):
        if not np.allclose(place, places[first[number[name]]]):
            raise FormatError(path, f"landmark {name} has two places", expected="one")
    return Landmarks(unique, places[first], _marks(path, columns, [number[name] for name in names]))


def _marks(path: Path, columns: dict[str, np.ndarray], of: list[int]) -> tuple[tuple[int, str, float, float], ...]:
    if "frame" not in columns:
        return ()
    if not all(name in columns and (name == "frame" or columns[name].dtype.kind == "f") for name in MARK):
        raise FormatError(path, "marks of landmarks", expected=", ".join(MARK), got=", ".join(columns))
    frames, u, v = (columns[name] for name in MARK)
    texts = [f"{frame:.0f}" if isinstance(frame, float | np.floating) else str(frame) for frame in frames.tolist()]
    rows = zip(of, texts, u.tolist(), v.tolist(), strict=True)
    return tuple((i, frame, x, y) for i, frame, x, y in rows if np.isfinite([x, y]).all())
