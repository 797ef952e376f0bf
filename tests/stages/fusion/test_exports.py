"""The pages in which a fused surface and a merged cloud can be turned: light, named, and of what is supported alone."""

import base64
import io
import re

import numpy as np
import pytest

from ipcli.models.fusion.holes import UNSEEN
from ipcli.stages.fusion import exports
from tests.fixtures.fusion_scenes import camera, cast, pose_at

SHAPE = (60, 80)


def fused():
    intrinsics = camera(SHAPE)
    depth = cast(SHAPE, intrinsics, pose_at((0, 0, 0))).astype(np.float32)
    filled = np.zeros(SHAPE, np.uint8)
    filled[:, :40] = UNSEEN
    normals = np.zeros((*SHAPE, 3), np.float32)
    normals[..., 2] = -1
    return {"depth": depth, "filled": filled, "normals": normals, "intrinsics": intrinsics}


def content(html):
    """Vertices (n, 3) of the scene in a page, where they stand in it."""
    import trimesh

    data = base64.b64decode(max(re.findall(r'base64_data="([^"]+)"', html), key=len))
    scene = trimesh.load(io.BytesIO(data), file_type="glb")
    return np.concatenate([np.asarray(geometry.vertices) for geometry in scene.geometry.values()]), scene


@pytest.mark.parametrize("most", [10**6, 600])
def test_the_surface_is_what_views_support_upright_and_light(tmp_path, monkeypatch, most):
    monkeypatch.setattr(exports, "VERTICES", most)
    exports.write_turnable("fuse-depth: x.h5", tmp_path / "x", fused(), {})
    html = (tmp_path / "x").read_text(encoding="utf-8")
    assert "<title>fuse-depth: x.h5</title>" in html
    assert "first seen from the reference camera" in html
    vertices, _ = content(html)
    assert len(vertices) <= min(most, SHAPE[0] * SHAPE[1] / 2)
    middle = np.median(fused()["depth"][:, 40:])
    assert np.ptp(vertices[:, 2]) == pytest.approx(np.ptp(fused()["depth"][:, 40:]), rel=0.2)
    assert vertices[:, 0].mean() > 0.2 * middle  # the right half alone


def test_a_cloud_is_thinned_and_lit_where_it_has_no_colours(tmp_path, monkeypatch):
    monkeypatch.setattr(exports, "POINTS", 100)
    points = np.random.default_rng(0).uniform((-1, -1, 2), (1, 1, 4), (950, 3)).astype(np.float32)
    normals = np.tile(np.array([0, 0, -1], np.float32), (950, 1))
    arrays = {"points": points, "normals": normals, "cam_from_world": np.eye(4)[None]}
    exports.write_turnable_cloud("merge-depth: x.h5", tmp_path / "x", arrays, {})
    html = (tmp_path / "x").read_text(encoding="utf-8")
    assert "<title>merge-depth: x.h5</title>" in html
    assert "95 of 950 points" in html
