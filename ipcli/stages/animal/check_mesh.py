"""model-animal check: whether a mesh is closed, and what it measures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ipcli.io.meshes import mesh
from ipcli.models.animal.soundness import soundness


def check(path: Path) -> dict[str, Any]:
    """Facts of a mesh file (PLY, OBJ, OFF, STL, GLB); FormatError when it cannot be read."""
    vertices, faces = mesh.read_joined(path)
    return {"mesh": str(path), **soundness(vertices, faces)}
