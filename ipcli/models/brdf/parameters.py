"""Parameters of chapter 7, each with the value that was found on generated scenes and on MIT's cup1."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.params import option


@dataclass(frozen=True)
class Weights:
    """The terms of the energy of `energy.ShadedProblem`."""

    normal: float = option(0.05, "Weight of the normals of the prior shape, w_n.", low=0.0)
    bending: float = option(0.1, "Weight of the bending of the displacement from the prior shape.", low=0.0)
    photo_width: float = option(0.03, "Residual of the shading from which it counts linearly.", low=1e-6)
    normal_width: float = option(0.1, "Sine of the angle to the prior from which it counts linearly.", low=1e-6)
    bending_width: float = option(0.02, "Curvature from which it counts linearly.", low=1e-6, unit="1/px")


@dataclass(frozen=True)
class Solid:
    """Reconstruction of an object whose silhouette is an occluding rim."""

    rounds: int = option(4, "Rounds of light and shape in turn.", low=1)
    steps: int = option(6, "Gauss-Newton steps a round.", low=1)
    last_steps: int = option(12, "Gauss-Newton steps at the end.", low=0)
    ridge: float = option(0.003, "Ridge of the harmonics, times the number of cells.", low=0.0)
    residual: float = option(0.05, "Mean residual of the first fit up to which the shading counts in full.", low=1e-6)
    albedos: int = option(3, "Most colours of the surface that are told apart.", low=1, high=8)
    weights: Weights = field(default_factory=Weights)


@dataclass(frozen=True)
class Sheet:
    """Reconstruction of a cut piece whose silhouette says nothing of its slope."""

    relief: float = option(
        0.3, "Height of the prior shape in heights of the balloon; at 0 convex and concave tie.", low=0.0, high=1.0
    )
    kappa: float = option(0.02, "Weight of the log determinant in the evidence of a map.", low=0.0)
    temperature: float = option(
        0.1, "Evidence, in least energies, that a map loses before its weight falls by e.", low=1e-6
    )
    best: int = option(6, "Maps that are solved on the full grid and averaged.", low=1)
    sweep_steps: int = option(6, "Gauss-Newton steps for each map of the sweep.", low=1)
    steps: int = option(18, "Gauss-Newton steps for each of the best maps.", low=1)
    sweep_bending: float = option(0.5, "Bending on the grid of the sweep, in bendings of the full one.", low=0.0)
    weights: Weights = field(default_factory=Weights)


@dataclass(frozen=True)
class LibraryLearning:
    """What brdf-train makes of each material."""

    lights: int = option(40, "Generated studio lights, beside the probes of the list.", flag="--lights", low=1)
    headings: int = option(4, "Turns of each probe about the vertical.", flag="--headings", low=1)
    scenes: int = option(900, "Generated scenes that the judge of rims learns from.", flag="--scenes", low=40)
    side: int = option(96, "Side of the generated pictures.", low=48, high=512, unit="px")
    pictures: int = option(
        250,
        "Generated pictures of each material that the classifier of materials learns from.",
        flag="--pictures",
        low=20,
    )
    grid: int = option(72, "Longest side on which features are taken; that of inference.", low=16, unit="px")
    relief: float = option(0.3, "Height in balloons that stands for a sheet.", low=0.0, high=1.0)


@dataclass(frozen=True)
class Coding:
    """The sparse autoencoder of the patches of a material."""

    units: tuple[int, ...] = (48, 16)  # of each layer
    activation: float = option(0.1, "Mean activation that units are held to.", low=1e-3, high=0.5)
    sparsity: float = option(0.1, "Weight of that.", low=0.0)
    l1: float = option(1e-4, "Weight of the absolute values of the weights.", low=0.0)
    iterations: int = option(60, "Iterations of OWL-QN a layer.", low=1)


@dataclass(frozen=True)
class Patches:
    """What small patches of the picture say of their normals, given the reflectance map."""

    surfaces: int = option(24, "Generated surfaces that are seen through the map.", low=4)
    each: int = option(150, "Patches taken of each.", low=10)
    side: int = option(5, "Side of a patch on the grid of inference, odd.", low=3, high=15, unit="px")
    components: int = option(6, "Principal components of its brightness.", low=1)
    balloon: float = option(
        17.0, "Concentration of the prior shape's normal that a patch is joined with, over n_z squared.", low=0.0
    )
    most: float = option(
        18.0, "Concentration of the surest patch: more than that the map, an estimate, does not allow.", low=1e-6
    )
    temperature: float = option(
        0.1, "Energy, in least energies, that a surface loses before its weight falls by e.", low=1e-6
    )


@dataclass(frozen=True)
class Printing:
    """The closed relief for a printer."""

    width: float | None = option(
        None, "Width of the object, to give sizes in mm; pixels if not given.", flag="--width-mm", low=1e-3, unit="mm"
    )
    plate: float = option(
        0.05, "Thickness of the back plate, in longest sides of the object.", flag="--plate", low=1e-3
    )
    depth: float = option(1.0, "Factor on the height of the printed relief.", flag="--depth", low=1e-3)


@dataclass(frozen=True)
class Refinement:
    """The convex refinement of a height field."""

    normal: float = option(1.0, "Weight of the normals of the shape it sets out from.", low=0.0)
    photo: float = option(0.5, "Weight of the normals that the shading asks for.", low=0.0)
    tgv: float = option(0.2, "Weight of TGV of order 2 of the height.", low=0.0)
    theta: float = option(0.5, "How far the normals of the shading may leave the surface at first.", low=1e-3)
    cap: float = option(
        25.0, "Angle about the normal within which the shading is searched.", low=1.0, high=89.0, unit="degrees"
    )
    candidates: int = option(15, "Normals tried a side of that cap.", low=3, high=99)
    rounds: int = option(3, "Rounds of normals and height in turn.", low=0)
    iterations: int = option(600, "Primal-dual iterations a round.", low=1)
    step: float = option(6.0, "Ratio of the primal to the dual step; larger where heights are large.", low=1e-3)


@dataclass(frozen=True)
class Plate:
    """The plate of finite elements that given normals are integrated with."""

    membrane: float = option(1e-4, "Stretching stiffness; pulls the relief flat.", low=0.0)
    plate: float = option(0.02, "Bending stiffness; smooths.", low=0.0)
    constraint: float = option(1.0, "Weight of the normals.", low=1e-9)


@dataclass(frozen=True)
class Inference:
    """From one picture to a surface."""

    rim: str = option(
        "auto",
        "What the silhouette is: an occluding rim (solid), a cut edge (sheet), half each (mixed), or as the "
        "library judges.",
        flag="--rim",
        choices=("auto", "solid", "sheet", "mixed"),
    )
    relief: str = option(
        "convex",
        "Which of two reliefs to take that one picture cannot tell apart; light-above: the one whose light comes "
        "from above.",
        flag="--relief",
        choices=("convex", "concave", "light-above"),
    )
    refine: str = option(
        "none",
        "Refinement at the end: none, or convex, primal-dual with TGV of the height on the grid of inference.",
        flag="--refine",
        choices=("none", "convex"),
    )
    use_patches: str = option(
        "prior",
        "What small patches say of a solid's normals once its map is known: none, or prior, where they join the prior.",
        flag="--patches",
        choices=("none", "prior"),
    )
    side: int = option(72, "Longest side of the object on the grid of inference.", low=16, high=400, unit="px")
    sweep_side: int = option(
        32, "Longest side on the grid where the maps of the library are compared.", low=8, high=200, unit="px"
    )
    maps: int = option(120, "Most maps of the library that are compared.", flag="--maps", low=1)
    least: float = option(0.1, "Least probability of sheet or solid for which it is worked out.", low=0.0, high=0.5)
    patches: Patches = field(default_factory=Patches)
    solid: Solid = field(default_factory=Solid)
    sheet: Sheet = field(default_factory=Sheet)
    refinement: Refinement = field(default_factory=Refinement)
    plate: Plate = field(default_factory=Plate)
