"""Parameters of the commands of depth fusion, one dataclass a command: all that their --help loads."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.fusion.parameters import Fusion, Merge
from ipcli.params import option, section


@dataclass(frozen=True)
class ViewSource:
    """What the files of a source of views do not say: None leaves the default of the layout.

    A hint that the layout has no use for is refused.
    """

    format: str = option("auto", "Layout: auto, views, colmap, tum, 7scenes, scannet, open3d, folder.", flag="--format")
    unit: str | None = option(None, "Unit of length of a plain folder.", flag="--unit")
    depth_scale: float | None = option(
        None, "Stored value of one unit of depth in 16-bit images.", flag="--depth-scale", low=0.0
    )
    intrinsics: tuple[float, ...] | None = option(
        None, "Calibration fx,fy,cx,cy of all views.", flag="--intrinsics", unit="px"
    )
    pose: str | None = option(
        None, "Direction of poses.txt.", flag="--pose", choices=("cam_from_world", "world_from_cam")
    )
    measured: str | None = option(
        None,
        "What the files of a plain folder hold; distance: along the ray of a pixel.",
        flag="--measured",
        choices=("depth", "disparity", "distance"),
    )
    baseline_focal: float | None = option(
        None, "Turns disparity into depth.", flag="--baseline-focal", low=0.0, unit="px * unit"
    )
    doffs: float | None = option(
        None, "Added to disparities: cx of the right camera less that of the left.", flag="--doffs", unit="px"
    )
    missing: float | None = option(None, "Stored value of a plain folder that means no data.", flag="--missing")
    depth: str | None = option(None, "Depth maps of COLMAP to take.", choices=("geometric", "photometric"))
    trajectory: str | None = option(None, "Trajectory file of an Open3D folder.")
    max_gap: float | None = option(None, "Longest time between a depth image and its pose (TUM).", low=0.0, unit="s")


@dataclass(frozen=True)
class FuseDepth:
    """Which views `fuse-depth` fuses into which, and how."""

    reference: str | None = option(None, "View to fuse into; the middle one if not given.", flag="--reference")
    camera: str | None = option(
        None,
        "TOML file of a camera to fuse into instead; the reference is then but the middle of the window.",
        flag="--camera",
    )
    window: int = option(0, "Views to fuse around the reference; 0: all.", flag="--window", low=0)
    every: bool = option(False, "Fuse into every view in turn; the output is a folder.", flag="--all")
    step: int = option(1, "With --all: only every so many-th view.", flag="--step", low=1)
    domain: str = option(
        "auto",
        "Quantity to regularise; auto: the one whose noise is homogeneous. Planes are affine in disparity.",
        flag="--domain",
        choices=("auto", "depth", "disparity"),
    )
    fusion: Fusion = field(default_factory=Fusion)
    source: ViewSource = field(default_factory=ViewSource)


@dataclass(frozen=True)
class MergeDepth:
    """Which points `merge-depth` keeps, and how finely."""

    merge: Merge = field(default_factory=Merge)


@dataclass(frozen=True)
class ImportViews:
    """Which views `import-views` takes, and what noise it adds to them."""

    views: str | None = option(None, "Names of the views to take, with commas.", flag="--views")
    reference: str | None = option(None, "View in the middle of the window.", flag="--reference")
    window: int | None = option(None, "Number of views to take around the reference.", flag="--window", low=1)
    noise: str | None = option(
        None, "Noise to add: laplace:SCALE or gauss:SCALE, in the unit (px for disparities).", flag="--noise"
    )
    outliers: float = option(0.0, "Share of pixels to replace by a random depth.", flag="--outliers", low=0.0, high=1.0)
    source: ViewSource = field(default_factory=ViewSource)


@dataclass(frozen=True)
class Sgbm:
    """Parameters of semi-global block matching, as OpenCV's."""

    disparities: int = option(160, "Length of the search, a multiple of 16.", low=16, high=1024, unit="px")
    block: int = option(5, "Side of the matched block, odd.", low=1, high=21, unit="px")
    small_step: int = option(4, "Penalty of a change by one disparity.", low=0)
    large_step: int = option(32, "Penalty of a larger change.", low=1)
    uniqueness: int = option(5, "Lead of the best match over the second, in per cent.", low=0, high=100)
    speckle_size: int = option(100, "Smallest patch kept; 0 keeps all.", low=0, unit="px^2")
    speckle_range: int = option(2, "Change of disparity that ends a patch.", low=0, unit="px")
    mode: str = option(
        "hh",
        "Paths of the matching: five (sgbm; low by 0.4 px on KITTI), eight (hh) or three.",
        choices=("sgbm", "hh", "3way"),
    )
    consistency: float | None = option(
        1.0, "Largest disagreement of left and right; none keeps all.", low=0.0, unit="px"
    )


@dataclass(frozen=True)
class KittiViews:
    """Which scenes `kitti-views` matches, with which poses and truth, and how."""

    scenes: str = option("all", "Scenes: all, or numbers with commas.", flag="--scenes")
    method: str = option("viso", "Set of poses in the NPZ.", flag="--method")
    truth: str = option(
        "noc",
        "Truth without (noc) or with (occ) pixels the right camera does not see.",
        flag="--truth",
        choices=("noc", "occ"),
    )
    sgbm: Sgbm = field(default_factory=Sgbm)


@dataclass(frozen=True)
class RenderViews:
    """The path of the camera of `render-views`, the camera, and its noise; the defaults are those of the thesis."""

    path: str = option(
        "orbit",
        "orbit: around the mesh, scaled to radius 1, at distance 3; strip: 300 above it, looking down.",
        flag="--path",
        choices=("orbit", "strip"),
    )
    views: int = option(11, "Number of views; fuse-depth takes the middle one as reference.", flag="--views", low=1)
    spacing: float | None = option(
        None, "Between views: times 5 degrees on an orbit (1), in units along a strip (4).", flag="--spacing", low=1e-6
    )
    up: str = option(
        "y", "Axis of the mesh that points up, on an orbit; a strip takes z.", flag="--up", choices=("x", "y", "z")
    )
    noise: str | None = option(None, "Noise to add: laplace:SCALE or gauss:SCALE, in the unit.", flag="--noise")
    width: int = option(640, "Width of the images.", flag="--width", low=8, unit="px")
    height: int = option(480, "Height of the images.", flag="--height", low=8, unit="px")
    focal: float = option(
        576.0, "Focal length; the principal point is (width / 2, height / 2).", flag="--focal", low=1.0, unit="px"
    )


@dataclass(frozen=True)
class CompareFusion:
    """Nothing to choose: the table of `compare` follows from the files."""


@dataclass(frozen=True)
class FusionTrials:
    """Which methods are tried on a scene, into which view, and everything else that they have in common."""

    methods: tuple[str, ...] = option(
        ("all",),
        "Each METHOD, or METHOD:ALGORITHM if its confidence is estimated; all: every one there is.",
        flag="--methods",
        aliases=("--method",),
    )
    reference: str | None = option(None, "View to fuse into; the middle one if not given.", flag="--reference")
    domain: str = option(
        "auto",
        "Quantity to regularise; auto: the one whose noise is homogeneous.",
        flag="--domain",
        choices=("auto", "depth", "disparity"),
    )
    fusion: Fusion = section(Fusion, without=("method", "algorithm", "lam"))


@dataclass(frozen=True)
class EvaluateFusion(FusionTrials):
    """The methods that `evaluate-fusion` tries, and whose maps it keeps beside the figures."""

    keep: tuple[str, ...] = option(
        ("tgv-l1", "l1-heuristic", "l1-adapt", "adapt-hprior"),
        "Methods whose maps are kept, to be looked at.",
        flag="--keep",
    )


@dataclass(frozen=True)
class TuneFusion(FusionTrials):
    """The methods that `tune-fusion` tries, the grid of lambda, and what counts as best on it."""

    lambdas: tuple[float, ...] = option(
        (0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8, 1.6, 3.2, 6.4),
        "Values of lambda to try, besides the automatic one.",
        flag="--lambdas",
        low=1e-9,
    )
    measure: str = option("RMSE", "Measure that is to be least on average over the scenes.", flag="--measure")
