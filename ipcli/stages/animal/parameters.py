"""Parameters of the commands of chapter 6."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.animal.parameters import Modelling
from ipcli.params import option

STEPS = ("aspects", "components", "assembly")


@dataclass(frozen=True)
class ModelAnimal:
    """How an animal is modelled, and which steps are run."""

    stop_after: str = option("assembly", "Last step to run.", flag="--stop-after", choices=STEPS)
    separate_parts: str = option(
        "none",
        "Also write each part as a closed body of its own, X.PART.stl (or ply, obj).",
        flag="--separate-parts",
        choices=("none", "stl", "ply", "obj"),
    )
    modelling: Modelling = field(default_factory=Modelling)
