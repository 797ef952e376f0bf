"""Views to write in the layout of a data set, read back and compare."""

from __future__ import annotations

import tarfile

import numpy as np
import pytest

from ipcli.measurements.views import View

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


@pytest.fixture(scope="session")
def hdm05_clips(real_data, tmp_path_factory):
    """The first AMC file of a standing action of three actors of HDM05, unpacked with their skeletons."""
    archive = real_data("mocap/hdm05_smij11") / "hdm05_smij11_raw_asf_amc.tar.xz"
    folder = tmp_path_factory.mktemp("hdm05")
    with tarfile.open(archive) as tar:
        wanted = [item for item in tar.getmembers() if "grabHighR" in item.name or item.name.endswith(".asf")]
        tar.extractall(folder, members=wanted, filter="data")
    found = sorted(folder.rglob("*.amc"), key=lambda path: path.name)
    first = {path.name.split("_")[1]: path for path in reversed(found)}
    return [first[actor] for actor in ("bd", "dg", "tr")]
