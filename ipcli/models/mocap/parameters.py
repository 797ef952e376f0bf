"""What can be chosen about learning and recognising actions, declared once for flags, configuration files and
provenance.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.inverse.bayes.parameters import Mixture
from ipcli.params import option

BODY = "body"  # the group of all groups
MOTION = "motion"  # the group of how all of it changes
SPLIT_KINDS = ("subjects", "leave-one-out", "one-to-rest", "published", "clips", "frames")  # what `splits` does
LEFT_OUT = "leave-actions-out"  # what `left_out` does


@dataclass(frozen=True)
class Features:
    """What is measured of a group of joints in a frame, and the coordinates that the mixtures live in."""

    kind: str = option(
        "aligned",
        "aligned: carries over to other people; thesis: as printed",
        flag="--features",
        choices=("aligned", "thesis"),
    )
    rotation_weight: float = option(
        0.0, "length that a turn by one radian counts as (aligned); 0: positions alone", low=0.0, unit="heights"
    )
    body: bool = option(True, "a group more: all groups together")
    motion: float = option(
        0.2,
        "a group more: how all of it changes from so long before a frame to so long after (aligned); 0: poses alone",
        flag="--motion",
        low=0.0,
        unit="s",
    )
    projection: str = option(
        "within", "coordinates: within (an action's spread is the unit) or standard", choices=("within", "standard")
    )
    shrinkage: float = option(0.2, "share of a sphere in an action's spread (within)", low=0.0, high=1.0)
    dimensions: int = option(8, "most dimensions of a group (within)", low=1)
    body_dimensions: int = option(20, "most dimensions of the groups of all groups and of motion (within)", low=1)


@dataclass(frozen=True)
class Learning:
    """How behaviours are learnt."""

    frames: int = option(800, "most frames of an action that are learnt from, drawn at random", flag="--frames", low=1)
    mirror: bool = option(
        False,
        "learn the mirror image of every clip as well: for actions that are the same by either hand",
        flag="--mirror",
    )
    spread: float = option(
        0.3,
        "variance by which other people differ from those learnt from, in the units of the coordinates",
        flag="--spread",
        low=0.0,
    )
    folds: int = option(
        5,
        "parts of the people that are held out in turn to calibrate when the answer is none; each costs a light model",
        flag="--folds",
        low=2,
    )
    fold_frames: int = option(200, "most frames of an action that those light models learn from", low=1)
    draws: int = option(2, "draws of the sampler that a prediction averages, at most", low=1)
    features: Features = field(default_factory=Features)
    mixture: Mixture = field(default_factory=Mixture)


@dataclass(frozen=True)
class Decision:
    """How the groups' answers make one, and the frames' answers one of a clip."""

    rule: str = option(
        "product",
        "product: groups count as independent, but for a power; mean: of the groups' posteriors; preferences: W of "
        "(5.12)",
        flag="--rule",
        choices=("product", "mean", "preferences"),
    )
    power: float = option(0.2, "power of a group in the product", low=0.0)
    body_power: float = option(0.3, "power of the group of all groups in the product", low=0.0)
    motion_power: float = option(0.7, "power of the group of motion in the product", low=0.0)
    preference: str = option("corrected", "normaliser of (5.12)", choices=("corrected", "printed"))
    prior_successes: float = option(1.0, "kappa of (5.12), of every group", low=0.0)
    evidence: float = option(2.0, "independent frames that a clip counts as, at most; neighbours say the same", low=1.0)
    reject: float = option(
        0.965, "share of new people's clips that must be named rather than called none", low=0.0, high=1.0
    )
