"""Binary STL, the format of printers: triangles with their normals, nothing shared."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.io.files import atomic

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write(path: Path, vertices: np.ndarray, faces: np.ndarray, header: str) -> None:
    """Write a mesh (n, 3), (m, 3) atomically; the header is cut at 79 bytes and never starts with `solid`, which means
    ASCII.
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets = np.zeros(len(faces), FACET)
    facets["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    facets["corners"] = corners
    head = b"-" + header.encode("ascii", "replace")[:78]
    atomic.write_bytes(path, head.ljust(80, b" ") + np.uint32(len(faces)).astype("<u4").tobytes() + facets.tobytes())
