from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, project, transform
from ipcli.io.files.images import read_image
from ipcli.io.views import layouts
from ipcli.measurements.views import relative

ROOT = Path(__file__).parents[2]
SHAPES = ROOT / "sample_data" / "shapes"


@pytest.fixture(scope="module")
def maker():
    """The script as a module; dataclasses look their module up by name."""
    spec = importlib.util.spec_from_file_location("make_sample_data", ROOT / "tools" / "make_sample_data.py")
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, spec.name, module)
        spec.loader.exec_module(module)
        yield module


@pytest.fixture(scope="module")
def sample():
    return layouts.open_views(SHAPES)


def content(path: Path) -> bytes:
    """Tables as they are, images decoded: encoders of two OpenCV versions may pack the same pixels differently."""
    import cv2

    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED).tobytes() if path.suffix == ".png" else path.read_bytes()


def test_the_files_of_a_view_and_the_tables_come_out_again_byte_for_byte(maker, tmp_path):
    maker.write_tables(tmp_path)
    maker.write_view(tmp_path, "003", maker.ANGLES["003"])
    made = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(made) == 6
    for path in made:
        assert content(tmp_path / path) == content(SHAPES / path), path


def test_the_sample_is_small_and_complete(sample):
    assert sample.names == tuple(f"{index:03d}" for index in range(11))
    assert sample.unit == "m"
    assert sum(path.stat().st_size for path in SHAPES.rglob("*")) < 3e6
    for name in sample.names:
        view = sample.load(name)
        assert view.depth.shape == (240, 320)
        assert np.isfinite(view.truth).all()
        assert view.image.std() > 20


def test_noise_outliers_and_holes_are_those_announced(maker, sample):
    view = sample.load("005")
    error = view.depth - view.truth
    known = np.isfinite(error)
    assert 0.01 < 1 - known.mean() < 0.15
    ordinary = np.abs(error[known])
    assert np.median(ordinary) == pytest.approx(maker.LAPLACE * np.log(2), rel=0.08)
    assert np.mean(ordinary > 10 * maker.LAPLACE) == pytest.approx(maker.OUTLIERS, rel=0.3)


def test_true_depth_and_colour_agree_between_views(sample):
    """What one camera sees at a point, another sees there too, unless something stands in between."""
    here, there = sample.load("004"), sample.load("006")
    points = transform(relative(there, here), back_project(here.truth, here.intrinsics)).reshape(-1, 3)
    pixels = np.rint(project(points, there.intrinsics))
    inside = ((pixels >= 0) & (pixels < (320, 240))).all(axis=1)
    u, v = pixels[inside].astype(int).T
    difference = points[inside, 2] - there.truth[v, u]
    visible = np.abs(difference) < 0.02
    assert visible.mean() > 0.9
    assert np.median(np.abs(difference)) < 0.004
    colours = here.image.reshape(-1, 3)[inside][visible].astype(int) - there.image[v, u][visible]
    assert np.median(np.abs(colours)) <= 4


def test_distances_of_the_scene_obey_the_equations_of_its_bodies(maker):
    """Points met by rays lie on their surface: two closed forms, and the ring, which is found by iteration."""
    pose = maker.camera(0.1)
    _, points, bodies = maker.trace(pose, maker.INTRINSICS, maker.SHAPE)
    ball = points[bodies == 3] - [-0.42, -0.36, 0.15]
    np.testing.assert_allclose(np.linalg.norm(ball, axis=1), 0.36, atol=1e-9)
    np.testing.assert_allclose(points[bodies == 0][:, 1], 0.0, atol=1e-9)
    axis = maker.unit(np.array([0.5, 0.25, -1.0]))
    offset = points[bodies == 7] - [0.24, -0.70, 0.74]
    along = offset @ axis
    across = np.linalg.norm(offset - along[:, None] * axis, axis=1)
    assert len(offset) > 200
    np.testing.assert_allclose(np.hypot(across - 0.17, along), 0.055, atol=1e-7)


def test_normals_are_perpendicular_to_the_surface_they_belong_to(maker):
    """The normal of each body against differences of neighbouring points on it."""
    _, points, bodies = maker.trace(maker.camera(0.0), maker.INTRINSICS, maker.SHAPE)
    grid, owner = points.reshape(*maker.SHAPE, 3), bodies.reshape(maker.SHAPE)
    for index, body in enumerate(maker.SCENE):
        same = (owner[1:-1, 1:-1] == index) & (owner[1:-1, 2:] == index) & (owner[1:-1, :-2] == index)
        tangent = maker.unit((grid[1:-1, 2:] - grid[1:-1, :-2])[same])
        assert np.median(np.abs((body.normal(grid[1:-1, 1:-1][same]) * tangent).sum(1))) < 0.02
    assert read_image(SHAPES / "image" / "000.png").shape == (*maker.SHAPE, 3)
