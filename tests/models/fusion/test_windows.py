"""What of a view is needed for a rectangle of the reference."""

import numpy as np
import pytest

from ipcli.measurements.views import View
from ipcli.models.fusion import windows
from ipcli.models.fusion.reprojection import reproject
from ipcli.models.fusion.windows import Excerpts, Landing, Window
from tests.fixtures.fusion_scenes import camera, cast, pose_at, scene

SHAPE = (60, 90)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(windows, "BLOCK", 16)
    monkeypatch.setattr(windows, "LOOKED_UP", 0)


def far_apart(turn):
    """A view from the side, with noise that scatters its points."""
    pose, intrinsics = pose_at((0.3, 0.05, 0.1), turn), camera(SHAPE)
    depth = cast(SHAPE, intrinsics, pose) * np.random.default_rng(0).uniform(0.8, 1.2, SHAPE)
    depth[::7] = np.nan
    return View("side", depth.astype(np.float32), intrinsics, pose)


@pytest.mark.parametrize("turn", [0.0, 0.2])
def test_all_that_lands_in_a_rectangle_is_in_the_part_of_it(turn):
    reference, view = scene(1, SHAPE)[0], far_apart(turn)
    whole, _ = reproject(view, reference)
    landing, sizes = Landing.of(view, reference), []
    for tile in windows.tiles(SHAPE, 24):
        part = landing.window(tile).camera(view)
        found, _ = reproject(part, tile.camera(reference))
        np.testing.assert_allclose(found, tile.of(whole), rtol=1e-6)
        sizes.append(part.depth.size / view.depth.size)
    assert np.median(sizes) < 0.7


def test_a_piece_about_the_centre_of_the_camera_may_land_anywhere():
    reference = scene(1, SHAPE)[0]
    view = View("inside", np.full(SHAPE, 2.0, np.float32), camera(SHAPE), pose_at((0.0, 0.0, -1.0), np.pi / 2))
    landing = Landing.of(view, reference)
    assert np.isinf(landing.boxes).any()
    whole, _ = reproject(view, reference)
    tile = Window(slice(20, 40), slice(30, 60))
    found, _ = reproject(landing.window(tile).camera(view), tile.camera(reference))
    np.testing.assert_allclose(found, tile.of(whole), rtol=1e-6)


def test_where_nothing_lands_one_pixel_is_asked_for():
    reference = scene(1, SHAPE)[0]
    away = View("away", np.full(SHAPE, np.nan, np.float32), camera(SHAPE), np.eye(4))
    asked = []

    def part(k, window):
        asked.append(window)
        return window.camera(away)

    views = Excerpts(part, [Landing.of(away, reference)], Window(slice(0, 20), slice(0, 20)))
    assert len(views) == 1
    assert views[0].depth.shape == (1, 1)
    assert asked == [Window(slice(0, 1), slice(0, 1))]
