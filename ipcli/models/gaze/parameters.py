"""What can be chosen about gaze localisation, declared once for flags, configuration files and provenance."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.params import option


@dataclass(frozen=True)
class Detection:
    """Features and their matches between the two cameras."""

    count: int = option(1500, "Most features a picture.", flag="--features", low=50)
    contrast: float = option(0.02, "Least contrast of a feature (SIFT); lower finds more in dark pictures.", low=0.0)
    band: float = option(2.0, "Rows by which the two cameras' sight of a point may differ.", low=0.1, unit="px")
    nearest: float = option(0.2, "Nearest scene point.", low=1e-3, unit="m")
    ratio: float = option(0.8, "Most a match's distance may be of the second best's.", low=0.1, high=1.0)


@dataclass(frozen=True)
class Tracking:
    """Pose of a frame against the map."""

    pose: str = option(
        "p3p", "Minimal solver inside RANSAC; fiore: the linear one of the thesis.", flag="--pose",
        choices=("p3p", "fiore"),
    )  # fmt: skip
    error: float = option(3.0, "Largest reprojection error of an inlier, in both cameras (3.3).", low=0.1, unit="px")
    least: int = option(20, "Fewest map points a pose must rest on; with fewer the frame is lost.", low=6)
    similar: int = option(4, "Past frames that look alike, to match with.", low=1)
    samples: int = option(400, "Most RANSAC samples.", low=10)


@dataclass(frozen=True)
class Mapping:
    """The map and its adjustment."""

    window: int = option(6, "Map frames that a local adjustment moves.", low=2)
    loss: float = option(1.0, "Scale of the Cauchy loss, in sigmas.", low=0.01)
    few: int = option(100, "A frame joins the map when its pose rests on fewer points than this.", low=0)
    overlap: float = option(0.6, "... or when less of it than this is known.", low=0.0, high=1.0)
    turn: float = option(8.0, "... or when it turned by so much since the last.", low=0.0, unit="degrees")
    rounds: int = option(2, "Global adjustments, each after points were matched anew.", low=0)


@dataclass(frozen=True)
class Keyframes:
    """When a new coherent subsequence begins (3.5)-(3.7)."""

    rule: str = option(
        "sampson", "Change of gaze: distance under the selected model; printed: (3.7) with |.|.",
        flag="--keyframe-rule", choices=("sampson", "printed"),
    )  # fmt: skip
    sigma: float = option(0.7, "Standard deviation of a feature's place, for GRIC.", low=0.01, unit="px")
    tau: float = option(3.0, "Change of gaze that starts a new one, in sigmas of the gaze.", low=0.1)
    samples: int = option(2, "... seen in so many frames one after the other.", low=1)
    longest: int = option(15, "Longest subsequence without gaze, where the head moves.", low=2, unit="frames")


@dataclass(frozen=True)
class Looking:
    """From gaze to points of regard."""

    sigma: float = option(
        1.0, "Error of the gaze: standard deviation along each axis.", flag="--gaze-sigma", low=0.01, unit="degrees"
    )
    disparities: int = option(96, "Longest search of the dense matching, a multiple of 16.", low=16, unit="px")
    disparity_sigma: float = option(0.3, "Error of a dense disparity.", low=0.01, unit="px")
    farthest: float = option(40.0, "Farthest point of regard.", low=0.5, unit="m")
    fixation: float = option(1.7, "Most the gaze of one fixation spreads: the fovea.", low=0.1, unit="degrees")
    shortest: float = option(0.1, "Shortest fixation.", low=0.0, unit="s")


@dataclass(frozen=True)
class Localisation:
    """All of gaze-sfm."""

    self_calibrate: str = option(
        "auto", "Correct a constant error of the disparities: auto where the sequence itself proves it.",
        flag="--self-calibrate", choices=("auto", "off", "on"),
    )  # fmt: skip
    global_ba: bool = option(True, "Adjust everything together at the end.", flag="--global-ba")
    detection: Detection = field(default_factory=Detection)
    tracking: Tracking = field(default_factory=Tracking)
    mapping: Mapping = field(default_factory=Mapping)
    keyframes: Keyframes = field(default_factory=Keyframes)
    looking: Looking = field(default_factory=Looking)
