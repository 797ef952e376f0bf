"""Options of the gaze commands."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.gaze.parameters import Localisation
from ipcli.params import option


@dataclass(frozen=True)
class RecordingSource:
    """Hints on the recording; None leaves the layout's own default."""

    format: str = option(
        "auto", "Layout: auto, recording, euroc, kitti, aria, boofcv, tum or 7scenes.", flag="--format"
    )
    gaze: str | None = option(None, "Gaze export, a file or its folder; beside or in place of its own.", flag="--gaze")
    gaze_shift: float = option(0.0, "Added to the times of the gaze.", flag="--gaze-shift", unit="s")
    gaze_size: tuple[int, ...] | None = option(
        None, "Width,height of the picture that the gaze was given for, if not the camera's.", flag="--gaze-size", low=1
    )
    calibrate_gaze: str | None = option(
        None, "Fixation targets (CSV: time [s],x [px],y [px]) that the gaze is corrected by.", flag="--calibrate-gaze"
    )
    intrinsics: tuple[float, ...] | None = option(
        None, "fx,fy,cx,cy of an RGB-D camera.", flag="--intrinsics", unit="px"
    )
    depth_scale: float | None = option(None, "Stored value of one metre of depth.", low=0.0)
    start: int = option(0, "First frame to take.", flag="--start", low=0)
    stop: int = option(0, "Frame to stop before; 0: the end.", flag="--stop", low=0)
    step: int = option(1, "Take every so many-th frame.", flag="--step", low=1)


@dataclass(frozen=True)
class GazeSfm:
    """What gaze-sfm takes."""

    poses_only: bool = option(False, "Only the head's path: no points of regard, no gaze.", flag="--poses-only")
    map: str | None = option(
        None,
        "Map and world to localise in, with one camera or more: a run (run.h5), or the folder of a COLMAP model.",
        flag="--map",
    )
    map_images: str | None = option(None, "Pictures of the COLMAP model of --map.", flag="--map-images")
    aoi: str | None = option(None, "Areas of interest: boxes or polygons (CSV), a labelled cloud (PLY).", flag="--aoi")
    aoi_margin: float = option(
        0.05, "How far from an area a point of regard still counts.", flag="--aoi-margin", low=0.0, unit="m"
    )
    world: str | None = option(
        None, "Landmarks (CSV) whose frame becomes the world: by names of the gaze or marks in frames.", flag="--world"
    )
    world_scale: bool = option(False, "Let the landmarks change the scale too.", flag="--world-scale")
    localisation: Localisation = field(default_factory=Localisation)
    source: RecordingSource = field(default_factory=RecordingSource)


@dataclass(frozen=True)
class Check:
    """What gaze-sfm check takes."""

    pairs: int = option(12, "Pairs to look at, spread over the recording.", flag="--pairs", low=2)
    localisation: Localisation = field(default_factory=Localisation)
    source: RecordingSource = field(default_factory=RecordingSource)


@dataclass(frozen=True)
class ImportRecording:
    """What import-recording takes."""

    source: RecordingSource = field(default_factory=RecordingSource)


@dataclass(frozen=True)
class GazeViews:
    """What gaze-views takes."""

    every: int = option(1, "Take every so many-th frame of the map.", flag="--every", low=1)
    disparity_sigma: float = option(0.4, "Error of a disparity, for its confidence.", low=0.01, unit="px")
    source: RecordingSource = field(default_factory=RecordingSource)
