"""Parameters of the models of chapter 6."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.params import option

LOADS = ("sqrt-poisson", "steep", "printed", "constant")
MERGES = ("hull", "clip", "union")
FIELDS = ("sdf", "ipf")
SEARCHES = ("image", "view", "twopoint", "hybrid")
OTHER_POSES = ("bend", "ignore")
METHODS = ("primal-dual", "irls")
GROUPS = ("similarity", "affine")
KEPT_STEPS, FREE_STEPS = 20, 2  # of flow where silhouettes stay covered, and where nothing holds a limb


@dataclass(frozen=True)
class Inflation:
    """How a mask becomes a closed surface (6.3.1)."""

    load: str = option(
        "sqrt-poisson",
        "What lifts the surface: sqrt-poisson and steep give round limbs, printed is the thesis' (6.4).",
        flag="--load",
        choices=LOADS,
    )
    gain: float = option(0.45, "Weight gamma of the loads steep, printed and constant.", low=0.0)
    concave_gain: float | None = option(None, "The weight gamma_2 beside concave rims; none: gain.", low=0.0)
    bending: float = option(
        0.0, "Bending length sqrt(b / l) over the largest radius of the mask; 0: a membrane.", low=0.0
    )
    triangles: int = option(1500, "About so many triangles a mask.", low=50)
    smoothing: float = option(1.0, "Deviation of the Gaussian that smooths the contour.", low=0.0, unit="pixels")


@dataclass(frozen=True)
class Registration:
    """How aspects of one part that show the same side are laid over each other (6.3.2)."""

    method: str = option("primal-dual", "Solver of each linear problem (6.8); both reach one optimum.", choices=METHODS)
    group: str = option("similarity", "Transforms; affine, the thesis' own, can undo a part's shape.", choices=GROUPS)


@dataclass(frozen=True)
class Volume:
    """The grid of the parts and the whole, and how they are merged and rounded."""

    merge: str = option(
        "hull",
        "Parts cut by all views' masks, united and rounded: hull keeps all silhouettes covered, clip does not. union, "
        "the thesis' way: all aspects as they are, cut by nothing.",
        flag="--merge",
        choices=MERGES,
    )
    field: str = option(
        "sdf",
        "Field of an aspect that is merged by union: signed distance, or the inner product field in our reading.",
        flag="--field",
        choices=FIELDS,
    )
    voxels: int = option(96, "Voxels along the longest side.", flag="--voxels", low=24, high=400)
    steps: int | None = option(
        None,
        "Steps of mean curvature flow on the whole, a sixth of a squared voxel each; none: 20 for hull, 2 else: there "
        "no silhouette keeps a limb, and one of radius sqrt(steps / 3) voxels is gone.",
        low=0,
    )

    @property
    def rounding(self) -> int:
        """The number of steps that are taken."""
        if self.steps is not None:
            return self.steps
        return KEPT_STEPS if self.merge == "hull" else FREE_STEPS


@dataclass(frozen=True)
class Modelling:
    """Everything that shapes a model."""

    inflation: Inflation = field(default_factory=Inflation)
    volume: Volume = field(default_factory=Volume)
    search: str = option(
        "image",
        "How the camera of an image without a view is found: image, by all labels at once; else part by part: view, by "
        "silhouettes; twopoint, by the thesis' energy; hybrid, by silhouettes among the views of least energy.",
        flag="--search",
        choices=SEARCHES,
    )
    other_pose: str = option(
        "bend",
        "Images of another pose: a model of them is bent into the reference pose to give the parts their shape.",
        flag="--other-pose",
        choices=OTHER_POSES,
    )
    registration: Registration = field(default_factory=Registration)
