"""Grids and inflation in closed form."""

import numpy as np

from ipcli.models.brdf import grid


def disc(radius, side=None):
    side = side or 2 * radius + 5
    rows, columns = np.indices((side, side)) - (side - 1) / 2
    return np.hypot(rows, columns) < radius


def ball(radius):
    mask = disc(radius)
    rows, columns = np.indices(mask.shape) - (len(mask) - 1) / 2
    return mask, np.sqrt(np.maximum(radius**2 - rows**2 - columns**2, 0))


def test_a_disc_inflates_to_a_hemisphere():
    mask, height = ball(40)
    found = grid.inflate(mask)
    assert np.abs(found - height)[disc(34, len(mask))].max() < 0.8
    assert np.abs(found**2 - height**2)[mask].max() < 2 * 40  # the outline of pixels is up to one wider than the disc


def test_slopes_and_bending_of_a_quadric_are_exact():
    mask = disc(12)
    of = grid.grid(mask)
    rows, columns = np.nonzero(mask)
    x, y = columns.astype(float), -rows.astype(float)
    z = 0.3 * x * x - 0.2 * y * y + 0.5 * x * y + 2 * x - y
    centre_x, centre_y = of.on_cells(x), of.on_cells(y)
    np.testing.assert_allclose(of.slope_x @ z, 0.6 * centre_x + 0.5 * centre_y + 2, atol=1e-9)
    np.testing.assert_allclose(of.slope_y @ z, -0.4 * centre_y + 0.5 * centre_x - 1, atol=1e-9)
    bends = [b @ z for b in of.bend]
    for bend, value in zip(bends, (0.6, -0.4, np.sqrt(2) * 0.5), strict=True):
        assert set(np.round(bend, 9)) <= {0.0, round(value, 9)}
        assert (bend != 0).mean() > 0.6


def test_normals_of_a_ball_are_its_own():
    mask, height = ball(60)
    rows, columns = np.indices(mask.shape) - (len(mask) - 1) / 2
    truth = np.stack([columns, -rows, height], axis=-1) / 60
    inner = disc(45, len(mask))
    found = grid.normals(height, mask)
    assert np.degrees(np.arccos(np.clip((found * truth).sum(axis=-1), -1, 1)))[inner].max() < 0.3
    assert np.isnan(found[~mask]).all()
