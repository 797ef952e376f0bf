"""Points of a plane and of a step, seen by one camera."""

import numpy as np

from ipcli.models.gaze.sparse_surface import sparse_surface

K = np.array([[200.0, 0, 80], [0, 200, 60], [0, 0, 1]])


def _seen(inverse):
    """Points at random pixels whose inverse depth is that of a function of the pixel."""
    pixels = np.random.default_rng(0).uniform([0, 0], [160, 120], (1000, 2))
    z = 1 / inverse(pixels)
    return np.column_stack([(pixels - [80, 60]) / 200 * z[:, None], z])


def test_a_plane_is_itself_between_its_points():
    surface = sparse_surface(_seen(lambda p: 0.5 + 0.001 * p[:, 0]), K, (120, 160), (20, 100))
    known = np.isfinite(surface.inverse)
    assert known[10:70, 15:145].mean() > 0.98
    v, u = np.nonzero(known)
    np.testing.assert_allclose(surface.inverse[known], 0.5 + 0.001 * u, atol=1e-9)
    assert surface.top == 20
    assert 0 < surface.sigma < 0.02


def test_no_triangle_spans_a_step_of_depth():
    surface = sparse_surface(_seen(lambda p: np.where(p[:, 0] < 80, 1.0, 0.4)), K, (120, 160), (0, 120))
    values = surface.inverse[np.isfinite(surface.inverse)]
    assert ((np.abs(values - 1.0) < 1e-9) | (np.abs(values - 0.4) < 1e-9)).all()
    assert np.isnan(surface.inverse[:, 78:82]).any()


def test_few_points_on_a_line_or_behind_say_nothing():
    line = np.column_stack([np.linspace(-0.3, 0.3, 9), np.zeros(9), np.ones(9)])
    for points in (line, line[:2], -line):
        assert np.isnan(sparse_surface(points, K, (120, 160), (0, 120)).inverse).all()
