"""What a head-mounted device recorded: pictures of one or two calibrated cameras (or one with depth), and gaze.

The frame of the rig is that of camera 0: x right, y down, z forward, metres. Pixels have their centres at integers and
are those of the picture as it was recorded, lens distortion included. Times are seconds on one clock.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera of the rig."""

    size: tuple[int, int]  # width, height in pixels
    intrinsics: np.ndarray  # (3, 3) float64, pixels
    model: str = "pinhole"  # of the lens, see geometry.lens
    distortion: np.ndarray = field(default_factory=lambda: np.zeros(0))  # its coefficients
    cam_from_rig: np.ndarray = field(default_factory=lambda: np.eye(4))  # (4, 4) rigid, metres


@dataclass(frozen=True, eq=False)
class Gaze:
    """Gaze samples. Where a sample has no direction of its own, its pixel in camera 0 gives it."""

    times: np.ndarray  # (n,) float64, seconds, ascending
    pixels: np.ndarray  # (n, 2) float64 in camera 0, NaN unknown
    valid: np.ndarray  # (n,) bool: confident, worn, no blink, inside the picture
    directions: np.ndarray | None = None  # (n, 3) unit vectors in the rig's frame, NaN unknown
    origins: np.ndarray | None = None  # (n, 3) metres in the rig's frame: between the eyes, say; None: camera 0
    labels: np.ndarray | None = None  # (n,) text: what was looked at, where somebody annotated it
    source: str = ""  # the export it is from
    dropped: tuple[str, ...] = ()  # what was left out and why, to be told


@dataclass(frozen=True, eq=False)
class FixationTargets:
    """Places in camera 0's pictures that were looked at for a while."""

    spans: np.ndarray  # (t, 2) seconds on the recording's clock: from, until
    pixels: np.ndarray  # (t, 2) distortion included


@dataclass(frozen=True, eq=False)
class Frame:
    """The pictures of one moment, grey (h, w) uint8; `colour` (h, w, 3) where the left one had colours."""

    left: np.ndarray
    right: np.ndarray | None = None
    depth: np.ndarray | None = None  # (h, w) float32 metres, NaN unknown
    colour: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class HeadRecording:
    """Frames in order, each read only when asked for."""

    names: tuple[str, ...]
    times: np.ndarray  # (k,) float64 seconds, ascending
    cameras: tuple[Camera, ...]  # one or two
    load: Callable[[int], Frame]
    files: tuple[Path, ...]  # everything it was made of, for the provenance
    gaze: Gaze | None = None
    truth: np.ndarray | None = None  # (k, 4, 4) world_from_rig where it is known, NaN elsewhere
    imu: np.ndarray | None = None  # (m, 7): time, angular rate rad/s, acceleration m/s^2, rig's axes
    targets: np.ndarray | None = None  # (t, 3) true places of what was looked at, in the frame of `truth`
    target_names: tuple[str, ...] = ()
    source: str = ""  # the layout it was read from
    dropped: tuple[str, ...] = ()  # what was left out and why, to be told

    @property
    def is_stereo(self) -> bool:
        """Whether there are two cameras."""
        return len(self.cameras) == 2


@dataclass(frozen=True, eq=False)
class PictureModel:
    """Points of a scene and the pictures that show them, as structure from motion leaves them."""

    points: np.ndarray  # (p, 3) float64, the model's unit
    grey: np.ndarray  # (p,) uint8
    poses: np.ndarray  # (k, 4, 4) cam_from_world of each picture
    shown: tuple[np.ndarray, ...]  # (m,) points that each picture shows
    pixels: tuple[np.ndarray, ...]  # (m, 2) where, pixel centres at integers
    load: Callable[[int], np.ndarray]  # the picture (h, w) uint8
    files: tuple[Path, ...]


@dataclass(frozen=True, eq=False)
class Areas:
    """Named boxes, plane polygons and labelled points, in the frame of the world; metres.

    The area of index i is `names[i]`; each has a shape in just one of the three.
    """

    names: tuple[str, ...]
    boxes: dict[int, np.ndarray] = field(default_factory=dict)  # (2, 3) low and high corner
    polygons: dict[int, np.ndarray] = field(default_factory=dict)  # (n, 3) corners in order, n >= 3
    clouds: dict[int, np.ndarray] = field(default_factory=dict)  # (n, 3) points of the area's surface


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Named places; each may be marked in some frames."""

    names: tuple[str, ...]
    places: np.ndarray  # (w, 3) metres in the frame that is to be the world
    marks: tuple[tuple[int, str, float, float], ...] = ()  # landmark, frame's name, u, v in camera 0's picture


def window(recording: HeadRecording, start: int, stop: int, step: int = 1) -> HeadRecording:
    """Frames start, start + step, ... before stop, with all gaze."""
    import dataclasses

    chosen = range(len(recording.names))[start : stop or None : step]
    return dataclasses.replace(
        recording,
        names=tuple(recording.names[k] for k in chosen),
        times=recording.times[list(chosen)],
        load=lambda k: recording.load(chosen[k]),
        truth=None if recording.truth is None else recording.truth[list(chosen)],
    )
