"""What can be chosen about a fusion, declared once for flags, configuration files and provenance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from ipcli.errors import ParameterError, nearest
from ipcli.inverse.regularize.parameters import Regulariser, Solver
from ipcli.params import option


@dataclass(frozen=True)
class Method:
    """A row of table 4.1: regulariser, data term, and where the confidence comes from."""

    order: int  # 2: TGV, 1: TV, 0: no regularisation
    deviation: str  # "absolute", "squared" or "huber"; without regularisation these mean median and mean
    adaptive: bool = False  # estimate the confidence with the depth
    normals: bool = False  # prior confidence (4.35) from the angle between surface and view
    edges: bool = False  # prior confidence (4.37) from the edges of the image
    each_view: bool = False  # a confidence for each observation in place of one for each pixel
    of_median: bool = False  # regularise the median instead of all observations


METHODS = {
    "mean": Method(0, "squared"),
    "median": Method(0, "absolute"),
    "rof": Method(1, "squared"),
    "rof-median": Method(1, "squared", of_median=True),
    "tv-l1": Method(1, "absolute"),
    "tgv-l1": Method(2, "absolute"),
    "tgv-huber": Method(2, "huber"),
    "l1-heuristic": Method(2, "absolute", normals=True),
    "rof-adapt": Method(1, "squared", adaptive=True),
    "l1-adapt": Method(2, "absolute", adaptive=True),
    "l1-adapt-views": Method(2, "absolute", adaptive=True, each_view=True),
    "adapt-hprior": Method(2, "absolute", adaptive=True, normals=True),
    "adapt-hprior-g": Method(2, "absolute", adaptive=True, normals=True, edges=True),
}
ALGORITHMS = ("acs", "ama", "biconvex")  # of an adaptive confidence, by their names in `alternation`


@dataclass(frozen=True)
class Confidence:
    """Hyper-parameters of the confidence L in (4.3), all relative to the noise scale of the observations.

    The defaults make the prior worth 20 observations at the noise scale: a confidence from K observations alone varies
    by 1/sqrt(K) where the noise does not, which cost more than it gained on the development scenes. The thesis' code
    takes shape 1.5 and rate 0.1, in the unit of the depth.
    """

    given: bool = option(True, "use the confidences that come with the views as weights", flag="--given-confidence")
    b: float = option(0.0, "weight of -log det L; 0: the pixel's number of observations + shape - 1", low=0.0)
    shape: float = option(21.0, "shape of the Gamma prior on a pixel's confidence", low=1.0)
    rate: float = option(20.0, "rate 1/(2W) of the Gamma prior; a prior confidence divides it", low=1e-6)
    edge_gain: float = option(1.0, "alpha of the edge confidence 1 + alpha g^beta, g in [0, 1]", low=0.0)
    edge_power: float = option(1.0, "beta of the edge confidence", low=0.0)
    edge_blur: float = option(1.0, "standard deviation of the blur of the image gradient", low=0.0, unit="px")


@dataclass(frozen=True)
class Edges:
    """Where the regulariser lets the map jump: at the jumps of a first map, in the passes after it and order 2, and of
    the image.
    """

    gain: float = option(
        2.0, "weight of the first-order term away from jumps, times alpha1; 0: 1 everywhere, as in the thesis", low=0.0
    )
    width: float = option(0.3, "jump that halves the weight, in noise scales over sqrt(K) for K observations", low=1e-6)
    image: float = option(
        0.0, "change of the image in a pixel that halves the weight, of 255; 0: the image has no say", low=0.0
    )


@dataclass(frozen=True)
class Holes:
    """Where no view supports the map, and what stands there."""

    fill: str = option(
        "background",
        "what stands there: the background along the row, or what the regulariser in-paints",
        flag="--fill",
        choices=("background", "regulariser"),
    )
    believed: float = option(
        5.0, "noise scales from the map within which an observation must lie to support it", low=1e-6
    )
    reach: float = option(
        100.0, "noise scales behind the in-painted surface beyond which a background is not taken", low=0.0
    )


@dataclass(frozen=True)
class Fusion:
    """Energy (4.3) and the algorithm that lowers it."""

    method: str = option("l1-adapt", "row of table 4.1", flag="--method", choices=tuple(METHODS))
    algorithm: str = option("acs", "how an adaptive confidence is found", flag="--algorithm", choices=ALGORITHMS)
    lam: float | None = option(
        None,
        "weight lambda of the data; more follows them, less smooths; if not given 1/sqrt(K), K views a pixel",
        flag="--lambda",
        low=0.0,
    )
    rounds: int = option(4, "rounds of confidence and depth at the most", flag="--rounds", low=1)
    reassociate: int = option(
        1,
        "times that observations are looked up anew by the map fused so far; 0: forward projection (4.34) alone",
        flag="--reassociate",
        low=0,
    )
    tile: int | None = option(
        None,
        "side of the tiles that are fused one by one, to bound memory; 0: one tile; if not given 1024 for large "
        "fusions, and less where --max-memory asks for it",
        low=0,
        unit="px",
    )
    huber: float = option(1.0, "width of the Huber deviation, in noise scales", low=1e-6)
    confidence: Confidence = field(default_factory=Confidence)
    edges: Edges = field(default_factory=Edges)
    holes: Holes = field(default_factory=Holes)
    regulariser: Regulariser = field(default_factory=lambda: Regulariser(alpha0=3.0))
    solver: Solver = field(default_factory=Solver)


@dataclass(frozen=True)
class Merge:
    """When several fused maps agree on a point, and how finely the points are told apart."""

    agree: int = option(2, "other maps that must see a point where it is", flag="--agree", low=0)
    tolerance: float = option(
        0.5, "largest difference in depth, in noise scales of one observation", flag="--tolerance", low=0.0
    )
    relative: float = option(
        0.005, "difference in depth that always counts as none, as a share of the depth", flag="--relative", low=0.0
    )
    angle: float = option(60.0, "largest angle between normals", flag="--angle", low=0.0, high=180.0, unit="degrees")
    neighbours: int = option(
        16, "other maps to ask, those that look at the same place from near by", flag="--neighbours", low=1
    )
    spacing: float | None = option(
        None,
        "side of the cells within which points are merged; if not given the median size of a pixel",
        flag="--spacing",
        low=0.0,
        unit="the unit",
    )


@dataclass(frozen=True)
class Variant:
    """A method of fusion, and how its confidence is found if it estimates one."""

    method: str
    algorithm: str | None

    @property
    def label(self) -> str:
        """The name that fuse-depth gives to its result."""
        return f"{self.method} ({self.algorithm})" if self.algorithm else self.method

    @property
    def is_regularised(self) -> bool:
        """Whether there is a lambda to choose."""
        return METHODS[self.method].order > 0

    def settings(self, fusion: Fusion, lam: float | None) -> Fusion:
        """The given settings with this method and lambda, None being the automatic one."""
        return replace(fusion, method=self.method, algorithm=self.algorithm or Fusion.algorithm, lam=lam)


def parse_variants(text: str) -> list[Variant]:
    """The variants that `all`, `METHOD` or `METHOD:ALGORITHM` stands for; ParameterError for an unknown one."""
    if text == "all":
        return [
            Variant(name, algorithm)
            for name, method in METHODS.items()
            for algorithm in (ALGORITHMS if method.adaptive else (None,))
        ]
    method, _, algorithm = text.partition(":")
    if method not in METHODS:
        raise ParameterError(f"unknown method '{method}'{nearest(method, METHODS)}")
    if algorithm and (algorithm not in ALGORITHMS or not METHODS[method].adaptive):
        takes = f"expected one of {', '.join(ALGORITHMS)}" if METHODS[method].adaptive else "it estimates no confidence"
        raise ParameterError(f"{text}: no such algorithm of this method ({takes})")
    return [Variant(method, algorithm or (Fusion.algorithm if METHODS[method].adaptive else None))]


def select_variants(texts: Iterable[str], fusion: Fusion) -> list[Variant]:
    """The variants of several texts, each once. ParameterError for settings that name a method or algorithm besides."""
    if (fusion.method, fusion.algorithm) != (Fusion.method, Fusion.algorithm):
        raise ParameterError("several methods are tried: name them by --methods, not by fusion.method or .algorithm")
    return list(dict.fromkeys(variant for text in texts for variant in parse_variants(text)))
