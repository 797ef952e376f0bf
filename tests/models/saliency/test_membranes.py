"""Membranes against figures found by quadrature with 25 digits, by quadrature here, and by a simulated wave."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import jv

from ipcli.models.saliency import membranes
from ipcli.models.saliency.scene_parameters import Membranes

UNDAMPED = Membranes(fading=0.0)


def gamma(r, theta, sigma, z):
    """(3.28)."""
    return 4 * r * sigma * np.exp(-(z**2) / (2 * sigma**2)) * np.sin(theta / z)


def test_coefficients_are_those_of_25_digits():
    a, b = membranes.coefficients(1.0, 2.3, 1.0)
    assert a[0, 0] == pytest.approx(0.162941997, rel=1e-8)
    assert a[1, 0] == pytest.approx(-0.120429776, rel=1e-8)
    assert b[1, 0] == pytest.approx(-0.0575588689, rel=1e-8)
    assert membranes.coefficients(1.0, 2.3, 3.0)[0][2, 1] == pytest.approx(0.0461237252, rel=1e-8)


@pytest.mark.parametrize(("m", "n", "z", "radius"), [(0, 1, 0.7, 1.0), (3, 4, 1.3, 5.0), (12, 9, 2.1, 3.0)])
def test_coefficients_are_the_integrals_of_the_initial_displacement(m, n, z, radius):
    """(3.26), (3.27) and the projection on Bessel functions, by quadrature."""
    root = membranes.modes().roots[m, n - 1]
    radial = quad(lambda r: r * r * jv(m, root * r / radius), 0, radius, epsabs=1e-13, limit=200)[0]
    scale = 2 * radial / (radius * jv(m + 1, root)) ** 2
    share = 1 / np.pi if m else 1 / (2 * np.pi)
    turns = [
        share * quad(lambda t, f=f: gamma(1.0, t, 0.8, z) * f(m * t), 0, 2 * np.pi, epsabs=1e-14, limit=200)[0]
        for f in (np.cos, np.sin)
    ]
    a, b = membranes.coefficients(0.8, z, radius)
    assert a[m, n - 1] == pytest.approx(scale * turns[0], rel=1e-8, abs=1e-14)
    assert b[m, n - 1] == pytest.approx(scale * turns[1], rel=1e-8, abs=1e-14)


@pytest.mark.parametrize("k", [1, 2, 5])
def test_where_z_is_one_over_an_integer_only_that_sine_is_left(k):
    cosine, sine = membranes.angular(np.array([1 / k]))
    expected = np.zeros(membranes.ORDERS)
    expected[k] = 1
    assert cosine[0] == pytest.approx(np.zeros(membranes.ORDERS), abs=1e-12)
    assert sine[0] == pytest.approx(expected, abs=1e-12)


def test_the_energy_is_constant_without_fading_and_that_of_a_drum():
    """Modal energy against quadrature over the membrane at rest: both 5.435092 for (12, 9)."""
    energy = membranes.energies(np.ones(1), np.array([2.3]), np.ones(1), 0.5, Membranes(score="physical", fading=0.0))
    table, c = membranes.modes(), membranes.speed(UNDAMPED)
    a, b = membranes.coefficients(1.0, 2.3, 1.0)
    assert energy[0] == pytest.approx(0.5 * (c**2 * table.roots**2 * table.area * (a**2 + b**2)).sum(), rel=1e-12)


def test_the_mean_square_is_that_of_the_displacement_over_membrane_and_time():
    """Closed form against a sum over points of the membrane and moments, with fading and without."""
    for p in (UNDAMPED, Membranes(fading=0.2)):
        radius, window = 2.0, 0.4
        s, weight = np.polynomial.legendre.leggauss(48)
        r, weight = radius * (s + 1) / 2, radius * weight / 2
        theta = np.arange(64) * (2 * np.pi / 64)
        t, time_weight = np.polynomial.legendre.leggauss(60)
        u = membranes.displacement(0.9, 1.7, radius, r, theta, window * (t + 1) / 2, p)
        summed = np.einsum("tra,t,r->", u**2, time_weight / 2, weight * r) * (2 * np.pi / 64)
        found = membranes.energies(np.array([0.9]), np.array([1.7]), np.array([radius]), window, p)
        assert found[0] == pytest.approx(summed, rel=1e-8)


def test_energies_in_time_have_the_mean_square_for_their_mean():
    sigma, z, radius = np.array([0.4, 1.5]), np.array([0.8, 1.9]), np.array([1.0, 5.0])
    times = 0.3 * (np.arange(3000) + 0.5) / 3000
    for p in (UNDAMPED, Membranes()):
        mean = membranes.energies_in_time(sigma, z, radius, times, p).mean(axis=1)
        assert membranes.energies(sigma, z, radius, 0.3, p) == pytest.approx(mean, rel=1e-6)


@pytest.mark.parametrize("fading", [0.0, 0.2])
def test_the_closed_form_moves_as_a_simulated_wave_does(fading):
    """Finite differences in r and t for one order of the angle, from the modes' own shape at rest."""
    p, m, radius, cells = Membranes(fading=fading), 2, 1.5, 400
    table, c = membranes.modes(), membranes.speed(p)
    r = radius * (np.arange(cells) + 0.5) / cells
    dr = radius / cells
    weights = np.array([0.5, -0.3, 0.2])
    roots = table.roots[m, :3]
    shapes = jv(m, roots[:, None] * r / radius)
    now = weights @ shapes
    k = 1 / fading if fading else 0.0
    dt, end = 0.4 * dr / c, 0.25

    def laplacian(u):
        around = np.concatenate([[(-1) ** m * u[0]], u, [-u[-1]]])
        outer, inner = (r + dr / 2) * (around[2:] - u), (r - dr / 2) * (u - around[:-2])
        return (outer - inner) / (r * dr**2) - m**2 * u / r**2

    before = now + 0.5 * dt**2 * c**2 * laplacian(now)
    for _ in range(round(end / dt)):
        after = (2 * now - (1 - k * dt) * before + dt**2 * c**2 * laplacian(now)) / (1 + k * dt)
        before, now = now, after
    swing = membranes.oscillation(membranes.angular_speed(radius, p)[m, :3], np.array([round(end / dt) * dt]), fading)
    assert now == pytest.approx((weights * swing[:, 0]) @ shapes, abs=2e-3)


def test_energy_grows_with_sigma_and_the_scores_agree_on_that():
    sigma = np.array([0.4, 0.8, 1.6])
    for score in ("mean-square", "printed", "physical"):
        found = membranes.energies(sigma, np.full(3, 1.2), np.full(3, 3.0), 0.3, Membranes(score=score))
        assert (np.diff(found) > 0).all()


def test_the_printed_score_is_the_sum_of_magnitudes():
    p, sigma, z, radius = Membranes(score="printed"), 0.7, 1.1, 2.0
    found = membranes.energies(np.full(2, sigma), np.array([z, 1.4]), np.full(2, radius), 0.3, p)[0]
    r = radius * (np.arange(membranes.RING) + 0.5) / membranes.RING
    theta = np.arange(membranes.TURN) * (2 * np.pi / membranes.TURN)
    times = np.linspace(0, 0.3, membranes.STEPS)
    summed = np.abs(membranes.displacement(sigma, z, radius, r, theta, times, p)).sum()
    assert found == pytest.approx(summed, rel=1e-3)
