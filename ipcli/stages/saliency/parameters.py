"""Options of the saliency commands."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.models.saliency.scene_parameters import SceneSaliency
from ipcli.params import option


@dataclass(frozen=True)
class Saliency:
    """What saliency takes."""

    model: str = option(
        "", "Earlier results X.h5,Y.h5 of saliency whose functions are applied, as their mean (3.20).", flag="--model"
    )
    cloud: str = option(
        "", "Cloud of the scene, of merge-depth or a PLY in the same world, in place of the map.", flag="--cloud"
    )
    format: str = option("auto", "Layout of views, where they are no artefact.", flag="--format")
    scene: SceneSaliency = field(default_factory=SceneSaliency)


@dataclass(frozen=True)
class SaliencyPredict:
    """What saliency-predict takes."""

    up: str = option(
        "y", "Axis of a mesh or cloud that points up.", flag="--up", choices=("x", "y", "z", "-x", "-y", "-z")
    )
    largest: int = option(1200, "Longer side of the pictures that the result keeps.", low=16, unit="px")


@dataclass(frozen=True)
class SaliencyTrain:
    """What saliency-train takes."""

    learning: FixationLearning = field(default_factory=FixationLearning)


@dataclass(frozen=True)
class SaliencyEvaluate:
    """What saliency-evaluate takes."""

    shown: int = option(6, "Items whose maps the page shows.", flag="--shown", low=0)
    learning: FixationLearning = field(default_factory=FixationLearning)
    validation: Validation = field(default_factory=Validation)
