"""Sheets: the scale and the map are found, the relief is better than the prior."""

import numpy as np
import pytest

from ipcli.models.brdf import evaluation, grid, parameters, sheet, solid
from ipcli.models.brdf.reflectance import Chart, Harmonics, chart_normals


def tables():
    n = chart_normals().reshape(-1, 3)
    rows = []
    for light in ([0.5, 0.3, 0.6], [-0.5, 0.4, 0.5], [0.1, -0.6, 0.6], [0, 0, 1.0]):
        rows.append(np.maximum(Harmonics(np.array([0.2, *light, 0, 0, 0, 0, 0])).slopes(n)[0], 0.01).reshape(65, 65))
    return np.array(rows)


def bent(side=72):
    mask = np.zeros((side, side), bool)
    mask[6:-6, 4:-4] = True
    x, y = np.meshgrid(np.arange(side), -np.arange(side))
    z = 4 * np.sin(x / 9.0 + 0.4) + 2 * np.cos(y / 11.0)
    picture = np.zeros((side, side, 3))
    picture[mask] = Chart(0.7 * tables()[0]).slopes(grid.normals(z, mask)[mask])[0][:, None]
    return mask[6:-6, 4:-4], z[6:-6, 4:-4], picture[6:-6, 4:-4]


def test_the_relief_is_found_under_the_true_map_of_unknown_brightness():
    mask, z, picture = bent()
    fine, coarse = solid.pictured(picture, mask, 72), solid.pictured(picture, mask, 32)
    found = sheet.sheet(fine, coarse, tables()[:1], parameters.Sheet(best=2))
    true = grid.normals(z, mask)
    inner = evaluation.inside(mask)
    shapes = (found.height, 0.3 * fine.inflated)
    ours, prior = (evaluation.normal_error(grid.normals(fine.grid.image(h, 0), mask), true, inner) for h in shapes)
    assert ours < 0.7 * prior


def test_a_map_that_cannot_explain_the_picture_has_no_weight():
    mask, _, picture = bent()
    fine, coarse = solid.pictured(picture, mask, 72), solid.pictured(picture, mask, 32)
    found = sheet.sheet(fine, coarse, tables(), parameters.Sheet(best=2, steps=6))
    assert found.weight.sum() == pytest.approx(1)
    assert found.weight[3] < 0.01  # light from the camera makes no slant dark enough
    assert found.energy.argmax() == 3


def test_representatives_cover_and_skip_doubles():
    rng = np.random.default_rng(0)
    few = rng.uniform(0.5, 1, (5, 65, 65))
    doubled = np.concatenate([few, 3 * few])  # brighter, else the same
    chosen = sheet.representatives(doubled, 5)
    assert sorted(c % 5 for c in chosen) == [0, 1, 2, 3, 4]
