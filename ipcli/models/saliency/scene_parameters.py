"""What can be chosen about saliency of scenes, declared once for flags, configuration files and provenance."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.params import option


@dataclass(frozen=True)
class SurfaceFit:
    """The thin plate of a subsequence (3.10)."""

    nodes: int = option(12_000, "Nodes of the surface of a subsequence.", flag="--nodes", low=100)
    over: str = option(
        "pixels", "What the surface is a function of: inverse depth over pixels, or Z over X and Y as printed.",
        flag="--surface", choices=("pixels", "plane"),
    )  # fmt: skip
    eta: float = option(1e-6, "Stiffness, for a domain of side 1 and per point.", low=0.0)
    robust_rounds: int = option(3, "Solves that weigh down points off the surface.", low=0)
    nearest: float = option(0.2, "Nearest point that is used.", low=1e-3, unit="m")


@dataclass(frozen=True)
class Membranes:
    """Vibration of the membranes (3.21) to (3.32)."""

    score: str = option(
        "mean-square", "Energy of a membrane: mean square of its displacement over the subsequence, sum of its "
        "magnitudes as printed, or physical energy of the modes taken.", flag="--energy",
        choices=("mean-square", "printed", "physical"),
    )  # fmt: skip
    frequency: float = option(4.0, "Base frequency of a membrane of radius 1.", low=0.01, unit="Hz")
    fading: float = option(0.25, "Time in which a vibration fades to 1/e; 0: never, as printed.", low=0.0, unit="s")


@dataclass(frozen=True)
class Classifying:
    """The function that tells attended points from others (3.17) to (3.20)."""

    form: str = option(
        "margin", "margin: two classes; one-class: (3.17) as printed; l1: few features.", flag="--classifier",
        choices=("margin", "one-class", "l1"),
    )  # fmt: skip
    split: str = option(
        "subsequence", "How folds are made: whole subsequences, or points at random as in table 3.1.", flag="--split",
        choices=("subsequence", "random"),
    )  # fmt: skip
    folds: int = option(3, "Folds of the cross-validation.", flag="--folds", low=2)
    width: float = option(1.0, "Width of the kernel, in standard deviations of the features.", low=0.01)
    penalty: float = option(1.0, "C of the margin; nu of one class is 0.1 / C.", low=1e-4)
    landmarks: int = option(200, "Points that the kernel is built on.", low=8)
    most: int = option(20_000, "Most points that are learnt from.", low=100)
    leave_out: str = option(
        "F1,F4",
        "Groups of features not used, or none: place and time let neighbours vouch for each other.",
        flag="--leave-out",
    )


@dataclass(frozen=True)
class SceneSaliency:
    """All that is chosen about a scene."""

    radius: float = option(
        0.3, "Radius of a coherent region around a point of regard, and of a proto-object.", flag="--radius", low=0.01,
        unit="m",
    )  # fmt: skip
    domain: str = option(
        "limited", "Where proto-objects may arise: limited, where the learnt function is above its threshold, the task "
        "domain of (F3); free, anywhere.", flag="--domain",
        choices=("limited", "free"),
    )  # fmt: skip
    objects: int = option(3, "Most proto-objects of a subsequence.", flag="--objects", low=1)
    excitation: str = option(
        "learnt", "What excites membranes: curvature alone (printed), or weighed by the learnt function.",
        flag="--excitation", choices=("learnt", "printed"),
    )  # fmt: skip
    group_size: int = option(1, "Most groups of features taken together in the table of error rates; 0: none.", low=0)
    surface: SurfaceFit = field(default_factory=SurfaceFit)
    membranes: Membranes = field(default_factory=Membranes)
    classifying: Classifying = field(default_factory=Classifying)
