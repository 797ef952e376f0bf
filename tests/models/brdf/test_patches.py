"""Patches given the map: they are cut where they are whole, tell normals better than chance, and join a prior."""

import numpy as np

from ipcli.models.brdf import patches, tree
from ipcli.models.brdf.energy import cell_normals
from ipcli.models.brdf.grid import grid
from ipcli.models.brdf.parameters import Patches
from ipcli.models.brdf.reflectance import Harmonics
from ipcli.models.brdf.solid import pictured


def test_patches_are_cut_around_whole_cells_only():
    mask = np.ones((6, 7), bool)
    mask[0, 0] = False
    cells = grid(mask)
    found, whole = patches.cut(cells, np.arange(len(cells.corners), dtype=float), 3)
    assert len(found) == whole.sum() == 3 * 4 - 1  # 5 x 6 cells less their edge, less the one at the missing corner
    np.testing.assert_array_equal(found[:, 4], np.flatnonzero(whole))


def test_given_the_map_patches_of_a_ball_know_more_than_that_it_faces_the_viewer():
    axis = (np.arange(40) + 0.5) / 20 - 1
    x, y = np.meshgrid(axis, -axis)
    mask = x * x + y * y < 0.95
    height = 20 * np.sqrt(np.maximum(1 - x * x - y * y, 0))
    light = Harmonics(np.array([0.3, 0.25, 0.45, 0.2, 0, 0, 0, 0, 0.05]))
    n = cell_normals(grid(mask), height[mask])
    picture = pictured(np.ones((40, 40, 3)), mask, 40)
    seen = type(picture)(picture.grid, light.slopes(n)[0], picture.colour, picture.inflated)
    said = patches.posterior(seen, light, np.ones(len(n)), Patches(surfaces=10, each=100))
    told = said.concentration > 0
    assert told.mean() > 0.6
    off = np.degrees(np.arccos(np.clip((said.normals * n).sum(axis=1), -1, 1)))[told]
    ahead = np.degrees(np.arccos(n[told, 2]))
    assert off.mean() < 0.9 * ahead.mean()


def test_what_is_sure_outweighs_the_prior_and_what_is_not_leaves_it():
    prior = np.tile([0.0, 0.0, 1.0], (2, 1))
    said = tree.PatchPosterior(np.tile([1.0, 0.0, 0.0], (2, 1)), np.array([0.0, 0.98]), np.zeros(2))
    both = patches.joined(prior, said, Patches(balloon=2.0))
    np.testing.assert_allclose(both[0], prior[0])
    assert both[1, 0] > 0.98


def test_the_map_bounds_what_patches_weigh_and_a_steep_prior_weighs_less():
    prior = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]])
    said = tree.PatchPosterior(np.tile([1.0, 0.0, 0.0], (2, 1)), np.ones(2), np.zeros(2))
    both = patches.joined(prior, said, Patches(balloon=10.0, most=5.0))
    np.testing.assert_allclose(both[:, 0] / (both * prior).sum(axis=1), [5 / 10, 5 / (10 * 0.64)])
