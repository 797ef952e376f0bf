"""Membrane and plate against closed forms on the unit disc, and at the rate at which they must converge."""

import numpy as np
import pytest

from ipcli.geometry.triangulation import resample, rim_of, triangulate_mask
from ipcli.inverse.regularize import finite_elements as fe


def disc(spacing):
    """A triangulated unit disc whose rim lies on the circle."""
    from scipy.spatial import Delaunay

    from ipcli.geometry.triangulation import hexagonal

    turn = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    rim = resample(np.stack([np.cos(turn), np.sin(turn)], axis=1), spacing)
    rim /= np.linalg.norm(rim, axis=1, keepdims=True)
    lattice = hexagonal(np.array([-1.0, -1]), np.array([1.0, 1]), spacing)
    lattice = lattice[np.linalg.norm(lattice, axis=1) < 1 - 0.6 * spacing]
    points = np.concatenate([[[0.0, 0.0]], rim, lattice[np.linalg.norm(lattice, axis=1) > 0.6 * spacing]])
    return points, Delaunay(points).simplices.astype(np.int64)


def one(x):
    return np.ones(x.shape[1:])


CENTRES = {
    "membrane": (lambda p, t: fe.membrane(p, t, one), 1 / 4),
    "clamped plate": (lambda p, t: fe.plate(p, t, one, 1.0, rim="clamped"), 1 / 64),
    "hinged plate": (lambda p, t: fe.plate(p, t, one, 1.0, rim="hinged"), 5 / 64),
}


@pytest.mark.parametrize("case", CENTRES)
def test_centre_of_the_unit_disc(case):
    solve, exact = CENTRES[case]
    assert solve(*disc(0.05))[0] == pytest.approx(exact, rel=0.006)


def test_two_membranes_one_after_the_other_are_naviers_plate():
    points, triangles = disc(0.05)
    moment = fe.membrane(points, triangles, one)
    from scipy.interpolate import LinearNDInterpolator

    field = LinearNDInterpolator(points, moment, fill_value=0.0)
    heights = fe.membrane(points, triangles, lambda x: field(x[0], x[1]))
    assert heights[0] == pytest.approx(3 / 64, rel=0.006)


@pytest.mark.parametrize("case", CENTRES)
def test_error_falls_with_the_square_of_the_spacing(case):
    solve, exact = CENTRES[case]
    spacings = np.array([0.2, 0.1, 0.05])
    errors = [abs(solve(*disc(h))[0] - exact) for h in spacings]
    rate = np.polyfit(np.log(spacings), np.log(errors), 1)[0]
    assert rate > 1.6


def test_stretching_and_bending_on_the_disc_agree_with_the_bessel_solution():
    """b lap^2 g - l lap g = 1, g = g' = 0 at 1:  g = A + (1 - r^2) / (4 l) + B I0(k r)  with k^2 = l / b."""
    from scipy.special import iv

    bending, stretching = 0.04, 1.0
    k = np.sqrt(stretching / bending)
    b = 1 / (2 * stretching * k * iv(1, k))
    exact = -b * iv(0, k) + 1 / (4 * stretching) + b
    points, triangles = disc(0.05)
    heights = fe.plate(points, triangles, one, bending, stretching, rim="clamped")
    assert heights[0] == pytest.approx(exact, rel=0.01)


def test_a_manufactured_membrane_is_met_everywhere():
    points, triangles = disc(0.1)
    exact = (1 - (points**2).sum(axis=1)) * (1 + points[:, 0])  # -lap = 4 + 8 u
    heights = fe.membrane(points, triangles, lambda x: 4 + 8 * x[0])
    assert np.abs(heights - exact).max() < 0.1**2 / 8 * 4  # the chord leaves h^2 / 8 of the disc out, slopes reach 4


@pytest.mark.parametrize("rim", ["hinged", "clamped"])
def test_the_stiffness_is_turned_with_the_mask(rim):
    points, triangles = disc(0.1)
    points = points * [1.0, 0.5]
    c = np.sqrt(0.5)
    turned = points @ np.array([[c, -c], [c, c]])
    first, second = (fe.plate(p, triangles, one, 0.3, 1.0, rim=rim) for p in (points, turned))
    assert np.abs(first - second).max() < 1e-9 * np.abs(first).max()


def test_twice_the_load_is_twice_the_height():
    points, triangles = disc(0.2)
    assert fe.membrane(points, triangles, lambda x: 2 * one(x)) == pytest.approx(
        2 * fe.membrane(points, triangles, one)
    )


def test_the_rim_stays_at_zero():
    mask = np.zeros((40, 60), bool)
    mask[5:30, 6:50] = True
    points, triangles = triangulate_mask(mask, 3.0)
    heights = fe.membrane(points, triangles, one)
    assert np.abs(heights[rim_of(triangles)]).max() == 0
    assert heights.min() >= 0


def test_an_unknown_rim_is_refused():
    with pytest.raises(ValueError, match="rim"):
        fe.plate(*disc(0.5), one, 1.0, rim="glued")
