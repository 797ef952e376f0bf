"""Binary STL as an independent reader sees it."""

import io

import numpy as np
import pytest

from ipcli.io.meshes import stl


def test_trimesh_reads_what_was_written(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(1)
    path = tmp_path / "ball.stl"
    stl.write(path, np.asarray(ball.vertices), np.asarray(ball.faces), "solid é" + "x" * 200)
    data = path.read_bytes()
    assert len(data) == 84 + 50 * len(ball.faces)
    assert not data.startswith(b"solid")
    read = trimesh.load(io.BytesIO(data), file_type="stl")
    assert read.is_watertight
    assert read.volume == pytest.approx(ball.volume, rel=1e-6)
