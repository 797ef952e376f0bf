"""The fusion in tiles against the fusion at once."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.inverse.regularize.parameters import Solver
from ipcli.models.fusion import tiles, windows
from ipcli.models.fusion.fuse import fuse
from ipcli.models.fusion.parameters import Confidence, Edges, Fusion
from ipcli.models.fusion.windows import Window
from tests.fixtures.fusion_scenes import scene

SHAPE = (90, 142)  # no multiple of the side
EXACT = Fusion(solver=Solver(tolerance=1e-4, iterations=800))
SIDE = 64


@pytest.fixture(scope="module")
def views():
    return scene(5, SHAPE, noise=0.02)


@pytest.fixture(autouse=True)
def narrow_margin(monkeypatch):
    """Narrower than the tiles, so that none of them sees the whole of so small an image."""
    monkeypatch.setattr(tiles, "MARGIN", 24)


def both(views, fusion=EXACT, inverse=False, reference=2):
    whole = fuse(views, views[reference], fusion, inverse=inverse)
    return whole, tiles.fuse_in_tiles(views, views[reference], fusion, SIDE, inverse=inverse)


def test_the_map_is_that_of_views_read_whole_bit_for_bit(views, monkeypatch):
    """What of a view cannot land in a tile is left unread, and changes nothing."""
    monkeypatch.setattr(windows, "BLOCK", 16)
    monkeypatch.setattr(windows, "LOOKED_UP", 8)
    asked = []

    def part(k, window):
        cut = window.camera(views[k])
        asked.append(cut.depth.size / views[k].depth.size)
        return cut

    found = tiles.fuse_in_tiles(views, views[2], Fusion(), SIDE, inverse=False, part=part)
    assert np.median(asked) < 0.75  # a tile and its margins are most of so small an image
    monkeypatch.setattr(windows.Landing, "window", lambda self, of_reference: Window(slice(0, None), slice(0, None)))
    whole = tiles.fuse_in_tiles(views, views[2], Fusion(), SIDE, inverse=False)
    for name in ("depth", "confidence", "observations", "mean", "median", "layers"):
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name))


# The weights of edges pass on what the quick first maps differ by, so that jumps are larger with them: measured are at
# most .028 without and .099 with them (.061 at a tolerance of 1e-5, which takes a minute).
@pytest.mark.parametrize(("edges", "jump"), [(Edges(gain=0.0), 0.04), (Edges(), 0.11)], ids=["even", "edges"])
@pytest.mark.parametrize("inverse", [False, True], ids=["depth", "disparity"])
def test_in_tiles_the_map_is_that_of_the_whole_and_has_no_seams(views, inverse, edges, jump):
    whole, tiled = both(views, replace(EXACT, edges=edges), inverse)
    assert tiled.noise_scale == pytest.approx(whole.noise_scale, rel=0.02)
    assert tiled.lam == pytest.approx(whole.lam)
    assert (tiled.observations == whole.observations).mean() > 0.998  # what is looked up depends on the map
    unit = 0.02  # the noise
    apart = np.abs(tiled.depth - whole.depth) / unit
    error = np.abs(whole.depth - views[2].truth).mean() / unit
    assert apart.mean() < 0.05 * error
    assert np.quantile(apart, 0.99) < 0.5 * error
    at_seams = np.concatenate(
        [apart[:, SIDE - 1 :: SIDE].ravel(), apart[SIDE - 1 :: SIDE].ravel(), apart[SIDE::SIDE].ravel()]
    )
    assert at_seams.mean() < 0.1 * error
    jumps = np.diff(tiled.depth - whole.depth, axis=1)[:, SIDE - 1 :: SIDE] / unit
    assert np.abs(jumps).mean() < jump * error


def test_one_tile_is_the_whole_but_for_the_windows_the_scale_comes_from(views):
    whole = fuse(views, views[2], Fusion(), inverse=False)
    tiled = tiles.fuse_in_tiles(
        views, views[2], Fusion(), 512, inverse=False
    )  # the windows cover all of so small an image
    for name in ("depth", "confidence", "observations", "mean", "median"):
        np.testing.assert_allclose(getattr(tiled, name), getattr(whole, name), rtol=1e-3)
    np.testing.assert_array_equal(tiled.layers, whole.layers[:, :: tiles.EVERY, :: tiles.EVERY])
    assert tiled.every == tiles.EVERY


def test_given_confidences_weigh_in_tiles_too(views):
    given = [replace(view, confidence=np.full(SHAPE, 1.0 + k, np.float32)) for k, view in enumerate(views)]
    quick = Fusion(confidence=Confidence(given=True))
    whole, tiled = both(given, quick)
    assert np.abs(tiled.depth - whole.depth).mean() < 0.1 * np.abs(whole.depth - views[2].truth).mean()


def test_a_tile_that_nothing_reaches_stays_empty(views):
    blind = []
    for view in views:
        depth = np.full(SHAPE, np.nan, np.float32)
        depth[:, 72:] = view.depth[:, 72:]
        blind.append(replace(view, depth=depth))
    tiled = tiles.fuse_in_tiles(blind, blind[2], Fusion(method="tgv-l1"), 32, inverse=False)
    assert np.isnan(tiled.depth[:, :32]).all()
    assert np.isfinite(tiled.depth[:, 100:]).all()
    assert not tiled.observations[:, :32].any()
    assert not tiled.confidence[:, :32].any()


def test_no_overlap_is_told(views):
    away = [replace(view, depth=np.full(SHAPE, np.nan, np.float32)) for view in views]
    with pytest.raises(NoSolution, match="no view has a valid depth"):
        tiles.fuse_in_tiles(away, away[2], Fusion(), SIDE, inverse=False)
