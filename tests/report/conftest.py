"""What pages are made of: artefacts small and large, and where they are from."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fixtures.pages import HOSTILE
from tests.fixtures.report_artefacts import fused_artefact, scene


@pytest.fixture
def artefact() -> dict[str, np.ndarray]:
    return fused_artefact()


@pytest.fixture
def large() -> dict[str, np.ndarray]:
    return fused_artefact(480, 640, 11)


@pytest.fixture
def provenance() -> dict[str, object]:
    return {
        "command": "fuse-depth",
        "ipcli": "0.1.0",
        "params": {"solver": {"gap": 0.001}, "reference": HOSTILE},
        "seed": 0,
        "inputs": [{"name": "a&b.h5", "sha256": "ab" * 32}],
        "digest": "cd" * 32,
    }


@pytest.fixture
def views_artefact() -> dict[str, np.ndarray]:
    arrays: dict[str, np.ndarray] = {"unit": np.array("m"), "measured": np.array("depth")}
    for index, name in enumerate(("b", "a", HOSTILE.replace("/", ""))):
        depth, intrinsics = scene(24, 32 + 4 * index)
        pose = np.eye(4)
        pose[0, 3] = -0.1 * index
        fields = {
            "depth": depth,
            "intrinsics": intrinsics,
            "cam_from_world": pose,
            "truth": depth,
            "image": np.full((*depth.shape, 3), 90, np.uint8),
        }
        arrays |= {f"views/{name}/{field}": array for field, array in fields.items()}
    return arrays
