"""Parameters of brdf-train and brdf-model. `--help` loads this and nothing of numpy."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.brdf.parameters import Inference, LibraryLearning, Printing
from ipcli.params import option


@dataclass(frozen=True)
class BrdfTrain:
    """What to learn from."""

    learning: LibraryLearning = field(default_factory=LibraryLearning)


@dataclass(frozen=True)
class BrdfModel:
    """How to read a photograph and what to make of it."""

    response: str = option(
        "srgb",
        "Numbers of the picture: srgb as cameras write JPEG and PNG, or linear in light.",
        flag="--response",
        choices=("srgb", "linear"),
    )
    normals: str = option(
        "opengl",
        "Convention of the normal map that is written: green up (opengl), down and facing in (opencv), green "
        "down (directx).",
        flag="--normals",
        choices=("opengl", "opencv", "directx"),
    )
    printing: Printing = field(default_factory=Printing)
    inference: Inference = field(default_factory=Inference)
