"""Views to write in the layout of a data set, read back and compare."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.geometry.cameras import View

INTRINSICS = np.array([[52.0, 0.0, 15.5], [0.0, 50.0, 11.5], [0.0, 0.0, 1.0]])


def rigid(rng: np.random.Generator) -> np.ndarray:
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation * np.sign(np.linalg.det(rotation)), rng.normal(size=3)
    return pose


@pytest.fixture
def views() -> list[View]:
    """Three views of 32 x 24 pixels with depth in whole millimetres, a hole, and one colour each (JPEG keeps it)."""
    rng = np.random.default_rng(8)
    made = []
    for index in range(3):
        depth = (rng.integers(500, 4000, (24, 32)) / 1000).astype(np.float32)
        depth[3:6, 10:14] = np.nan
        image = np.full((24, 32, 3), (40 + 60 * index, 120, 200 - 40 * index), np.uint8)
        made.append(View(f"{index}", depth, INTRINSICS, rigid(rng), image=image))
    return made


@pytest.fixture
def same():
    """Compare a view that was read with the one that was written."""

    def compare(read: View, written: View, *, image: bool = True, pose_tolerance: float = 1e-9) -> None:
        np.testing.assert_array_equal(read.depth, written.depth)
        assert read.depth.dtype == np.float32
        np.testing.assert_allclose(read.intrinsics, written.intrinsics)
        np.testing.assert_allclose(read.cam_from_world, written.cam_from_world, atol=pose_tolerance)
        if image:
            np.testing.assert_allclose(read.image.astype(int), written.image, atol=2)

    return compare
