"""Flow that keeps the silhouettes covered."""

import numpy as np
import pytest

from ipcli.geometry.level_sets import STABLE, flow
from ipcli.geometry.voxels import FAR, Sight
from ipcli.models.animal import rims, whole
from tests.fixtures import limbs

VIEWS = ("left", "right", "front", "back", "top")


@pytest.fixture(scope="module")
def taken():
    return limbs.shots(VIEWS)


def test_rims_stay_covered_while_the_surface_is_rounded(taken):
    images, truth = zip(*taken[:3], strict=True)
    grid = whole.grid_of(images, truth, 56)
    shots = whole.shots_of(images, truth, grid)
    outlines = [s.sight.silhouette_distance(s.image.silhouette) for s in shots]
    hull = np.maximum.reduce(outlines)
    kept = rims.round_off(hull, hull, [s.sight for s in shots], outlines, 30)
    for shot, rim in zip(shots, outlines, strict=True):
        sight: Sight = shot.sight
        wanted = rims.wanted_depth(sight, rim)
        inside = (wanted < -0.6) & (sight.least(hull) < FAR / 2)
        missed = [(sight.least(phi)[inside] > 0).mean() for phi in (kept, flow(hull, 30 * STABLE))]
        assert missed[0] < 0.02
        assert missed[0] < missed[1]


def test_within_reach_only_what_lies_beside_the_rims_grows(taken):
    images, truth = zip(*taken[:3], strict=True)
    grid = whole.grid_of(images, truth, 56)
    shots = whole.shots_of(images, truth, grid)
    sights = [s.sight for s in shots]
    outlines = [s.sight.silhouette_distance(s.image.silhouette) for s in shots]
    hull = np.maximum.reduce(outlines)
    wanted = [rims.wanted_depth(sight, rim) for sight, rim in zip(sights, outlines, strict=True)]
    thin = hull + 2.0  # lacks two voxels everywhere
    near, far = (rims.keep_rims(thin, hull, sights, wanted, reach) for reach in (3.0, np.inf))
    for sight, want in zip(sights, wanted, strict=True):
        lack = [(sight.least(phi) - np.maximum(want, sight.least(hull)))[want < 0] for phi in (near, thin)]
        assert (lack[0] < 0.5).all()  # named views, whose rays hold a column of voxels each, are reached wholly
        assert (lack[1] > 0.5).mean() > 0.3
    assert (thin < 0).sum() < (near < 0).sum() < (far < 0).sum()
