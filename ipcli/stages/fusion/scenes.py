"""A scene whose truth is known, fused by one method after another in one process: what tune-fusion and evaluate-fusion
share.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.models.fusion.parameters import METHODS, Fusion
from ipcli.params import option

if TYPE_CHECKING:
    import numpy as np

    from ipcli.measurements.views import View
    from ipcli.models.fusion.fuse import Fused

ALGORITHMS = ("acs", "ama", "biconvex")


@dataclass(frozen=True)
class Trials:
    """Which methods, into which view, and everything else that they have in common."""

    methods: tuple[str, ...] = option(
        ("all",),
        "Each METHOD, or METHOD:ALGORITHM if its confidence is estimated; all: every one there is.",
        flag="--methods",
    )
    reference: str | None = option(None, "View to fuse into; the middle one if not given.", flag="--reference")
    domain: str = option(
        "auto",
        "Quantity to regularise; auto: the one whose noise is homogeneous.",
        flag="--domain",
        choices=("auto", "depth", "disparity"),
    )
    fusion: Fusion = field(default_factory=Fusion)

    @property
    def variants(self) -> list[Variant]:
        """The methods asked for. ParameterError for an unknown one, and for settings that --methods overrules."""
        if (self.fusion.method, self.fusion.algorithm) != (Fusion.method, Fusion.algorithm):
            raise ParameterError("several methods are tried: name them by --methods, not by --method and --algorithm")
        return list(dict.fromkeys(variant for text in self.methods for variant in parse(text)))


@dataclass(frozen=True)
class Variant:
    """A method, and how its confidence is found if it estimates one."""

    method: str
    algorithm: str | None

    @property
    def label(self) -> str:
        """As fuse-depth calls its result."""
        return f"{self.method} ({self.algorithm})" if self.algorithm else self.method

    @property
    def is_regularised(self) -> bool:
        """Whether there is a lambda to choose."""
        return METHODS[self.method].order > 0

    def of(self, fusion: Fusion, lam: float | None) -> Fusion:
        """The settings with this method and lambda, None being the automatic one."""
        return replace(fusion, method=self.method, algorithm=self.algorithm or Fusion.algorithm, lam=lam)


def parse(text: str) -> list[Variant]:
    """The variants that `all`, `METHOD` or `METHOD:ALGORITHM` stands for."""
    if text == "all":
        adaptive = {name: ALGORITHMS if method.adaptive else (None,) for name, method in METHODS.items()}
        return [Variant(name, algorithm) for name, algorithms in adaptive.items() for algorithm in algorithms]
    method, _, algorithm = text.partition(":")
    if method not in METHODS:
        raise ParameterError(f"unknown method '{method}'{nearest(method, METHODS)}")
    if algorithm and (algorithm not in ALGORITHMS or not METHODS[method].adaptive):
        takes = f"expected one of {', '.join(ALGORITHMS)}" if METHODS[method].adaptive else "it estimates no confidence"
        raise ParameterError(f"{text}: no such algorithm of this method ({takes})")
    return [Variant(method, algorithm or (Fusion.algorithm if METHODS[method].adaptive else None))]


@dataclass(frozen=True, eq=False)
class Judged:
    """A map to be held against the truth, and what is known about it besides."""

    depth: np.ndarray  # (h, w), NaN where nothing was observed
    normals: np.ndarray | None = None  # (h, w, 3), if not those of the depth
    confidence: np.ndarray | None = None  # (h, w)
    uncertainty: np.ndarray | None = None  # (h, w)

    @classmethod
    def of(cls, fused: Fused) -> Judged:
        """What was fused, without what was in-painted."""
        import numpy as np

        depth = np.where(fused.observations > 0, fused.depth, np.nan).astype(np.float32)
        return cls(depth, fused.normals, fused.confidence, fused.uncertainty)

    @property
    def confidence_or_none(self) -> np.ndarray:
        """The confidence, 0 everywhere if there is none."""
        import numpy as np

        return np.zeros(self.depth.shape, np.float32) if self.confidence is None else self.confidence


@dataclass(frozen=True, eq=False)
class Scene:
    """Views in memory, the one to fuse into with its truth, and the quantity to fuse."""

    views: Sequence[View]
    reference: View
    inverse: bool
    baseline_focal: float | None
    unit: str

    def fuse(self, variant: Variant, fusion: Fusion, lam: float | None = None) -> Fused:
        """The fused map of one method."""
        from ipcli.models.fusion.fuse import fuse

        return fuse(self.views, self.reference, variant.of(fusion, lam), inverse=self.inverse)

    def errors(self, found: Mapping[str, Judged]) -> tuple[list[str], np.ndarray]:
        """Columns and rows of the error measures of maps, all taken on the pixels that every one of them has."""
        from ipcli.models.fusion.metrics import compare

        maps = {name: one.depth for name, one in found.items()}
        own = {name: one.normals for name, one in found.items() if one.normals is not None}
        return compare(maps, self.reference.truth, self.reference.intrinsics, self.baseline_focal, own)


def open_scene(path: Path, trials: Trials) -> Scene:
    """All views at `path`. FormatError if the view to fuse into has no truth."""
    from ipcli import threads
    from ipcli.io.views import layouts

    sequence = layouts.open_views(path)
    name = trials.reference or sequence.names[(len(sequence.names) - 1) // 2]
    views = dict(zip(sequence.names, threads.each(sequence.load, sequence.names), strict=True))
    if name not in views:
        raise ParameterError(f"{path}: no view '{name}'{nearest(name, views)}")
    if views[name].truth is None:
        raise FormatError(
            path, f"the true depth of view '{name}' is not known", fix="Give views whose reference has a truth"
        )
    domain = sequence.measured if trials.domain == "auto" else trials.domain
    return Scene(list(views.values()), views[name], domain == "disparity", sequence.baseline_focal, sequence.unit)
