"""model-animal check: whether a mesh is closed, and what it measures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ipcli.io.meshes import mesh
from ipcli.models.animal.soundness import soundness
from ipcli.stages.kit.summary import Figure

WORDS = {
    "volume": "in the mesh's own unit, cubed",
    "thinnest": "in that unit, from a face straight inwards to the next",
    "thickness_1_percent": "in that unit: 1 % of the faces are thinner",
}


def check(path: Path) -> dict[str, Any]:
    """Facts of a mesh file (PLY, OBJ, OFF, STL, GLB); FormatError when it cannot be read."""
    vertices, faces = mesh.read_joined(path)
    return {"mesh": str(path), **soundness(vertices, faces)}


def told(facts: Mapping[str, Any]) -> dict[str, Any]:
    """The same facts with words for a person."""
    figures = {name: Figure(facts[name], f"{facts[name]:.4g} ({words})") for name, words in WORDS.items()}
    return {**facts, **figures}
