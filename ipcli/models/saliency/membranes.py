"""Vibrating circular membranes (3.21) to (3.32), corrected; docs/errata.md says what was wrong.

A membrane of radius a, clamped at its rim, starts at rest from gamma = S r sin(theta / z), S = 4 sigma
exp(-z^2 / (2 sigma^2)) (3.28), and moves as

    u = sum_mn J_m(j_mn r / a) (A_mn cos m theta + B_mn sin m theta) g_mn(t),    g_mn = cos(w_mn t), w_mn = c j_mn / a.

A_mn = a S (2 I_mn / J_{m+1}(j_mn)^2) C_m(z), B_mn likewise with D_m: radius, strength and z separate, so that the
energies of all nodes of a surface are products of short tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ipcli.models.saliency.scene_parameters import Membranes

ORDERS, ROOTS = 13, 9  # m = 0 .. 12, n = 1 .. 9
FIRST_ROOT = 2.404825557695773
GAUSS = 64  # Legendre nodes: I_mn to 2e-16 for all modes taken
KNOTS = 33  # radii at which factors of time are tabulated
RING, TURN = 12, 36  # points of a membrane over which magnitudes are summed
STEPS = 30  # times at which they are


@dataclass(frozen=True, eq=False)
class Modes:
    """Tables of the modes: (orders, roots) each."""

    roots: np.ndarray  # j_mn
    norm: np.ndarray  # J_{m+1}(j_mn)^2
    radial: np.ndarray  # 2 I_mn / J_{m+1}(j_mn)^2, I_mn = int_0^1 s^2 J_m(j_mn s) ds
    area: np.ndarray  # of the mode's square over a membrane of radius 1: eps_m pi / 2 J_{m+1}^2, eps_0 = 2


@cache
def modes(orders: int = ORDERS, roots: int = ROOTS) -> Modes:
    """The tables, by Gauss-Legendre quadrature: the 1F2 series of (3.31) loses all its digits in float64."""
    from scipy.special import jn_zeros, jv

    m = np.arange(orders)[:, None]
    zeros = np.stack([jn_zeros(order, roots) for order in range(orders)])
    s, weights = np.polynomial.legendre.leggauss(GAUSS)
    s, weights = (s + 1) / 2, weights / 2
    integrals = (weights * s**2 * jv(m[..., None], zeros[..., None] * s)).sum(axis=-1)
    norm = jv(m + 1, zeros) ** 2
    return Modes(zeros, norm, 2 * integrals / norm, np.where(m == 0, np.pi, np.pi / 2) * norm)


def strength(sigma: np.ndarray, z: np.ndarray) -> np.ndarray:
    """S = 4 sigma exp(-z^2 / (2 sigma^2)) of (3.28)."""
    return 4 * sigma * np.exp(-((z / sigma) ** 2) / 2)


def angular(z: np.ndarray, orders: int = ORDERS) -> tuple[np.ndarray, np.ndarray]:
    """C_m / (S r) and D_m / (S r) of (3.29) and (3.30), (n, orders), for z (n,); their removable poles removed."""
    x = 1 / np.asarray(z, np.float64)[:, None]
    m = np.arange(orders)[None]
    off = x - m
    cosine = np.where(m == 0, 1.0, 2 * off / (x + m)) * np.pi * x * np.sinc(off) ** 2
    sine = 2 * m * np.sinc(2 * off) / (x + m)
    return cosine, sine


def coefficients(sigma: float, z: float, radius: float, orders: int = ORDERS, roots: int = ROOTS):
    """A_mn and B_mn (orders, roots) of (3.31) and (3.32), corrected."""
    cosine, sine = angular(np.array([z]), orders)
    scale = radius * float(strength(np.array(sigma), np.array(z))) * modes(orders, roots).radial
    return scale * cosine.T, scale * sine.T


def displacement(
    sigma: float, z: float, radius: float, r: np.ndarray, theta: np.ndarray, times: np.ndarray, p: Membranes
) -> np.ndarray:
    """u (times, r, theta) of (3.24) at radii (.. <= radius) and angles."""
    from scipy.special import jv

    table = modes()
    a, b = coefficients(sigma, z, radius)
    m = np.arange(ORDERS)
    shape = jv(m[:, None, None], table.roots[..., None] * (r / radius))  # orders, roots, r
    turn = a[..., None] * np.cos(m[:, None, None] * theta) + b[..., None] * np.sin(m[:, None, None] * theta)
    swing = oscillation(angular_speed(radius, p), times, p.fading)  # orders, roots, times
    return np.einsum("mnr,mna,mnt->tra", shape, turn, swing, optimize=True)


def shown(parameters: np.ndarray, window: float, p: Membranes) -> dict[str, np.ndarray]:
    """Displacements (n, times, rings, angles) of membranes with these sigma, z and radius (n, 3), to be looked at."""
    times, theta = np.linspace(0, window, STEPS), np.arange(TURN) * (2 * np.pi / TURN)
    rims = np.linspace(0, 1, RING + 1)
    shapes = [displacement(s, z, a, a * rims, theta, times, p) for s, z, a in parameters.tolist()]
    return {
        "membranes/parameters": parameters,
        "membranes/times": times,
        "membranes/shapes": np.array(shapes, np.float32).reshape(len(parameters), STEPS, RING + 1, TURN),
    }


def speed(p: Membranes) -> float:
    """c of (3.21) that gives a membrane of radius 1 its base frequency."""
    return 2 * np.pi * p.frequency / FIRST_ROOT


def angular_speed(radius: float, p: Membranes) -> np.ndarray:
    """w_mn = c j_mn / a, rad/s."""
    return speed(p) / radius * modes().roots


def _damping(w: np.ndarray, fading: float) -> tuple[float, np.ndarray]:
    """k = 1 / fading and w_d = sqrt(w^2 - k^2), complex so that overdamped modes need no case of their own."""
    k = 1 / fading if fading > 0 else 0.0
    return k, np.sqrt((w**2 - k**2).astype(complex) + 1e-12)


def oscillation(w: np.ndarray, times: np.ndarray, fading: float) -> np.ndarray:
    """g(t) (..., times) of u_tt + 2 k u_t = c^2 lap u from rest: cos(w t) without fading."""
    k, wd = _damping(w, fading)
    wd = wd[..., None]
    return (np.exp(-k * times) * (np.cos(wd * times) + k / wd * np.sin(wd * times))).real


def mean_square(w: np.ndarray, window: float, fading: float) -> np.ndarray:
    """Mean of g(t)^2 over [0, window], in closed form; (1 + sinc(2 w T)) / 2 without fading."""
    if window <= 0:
        return np.ones_like(w)
    k, wd = _damping(w, fading)
    q = k / wd
    decay = 2 * k
    flat = window if decay == 0 else -np.expm1(-decay * window) / decay
    # int_0^T exp((2 i wd - 2 k) t) dt, and with -wd: cosine and sine parts also for complex wd
    plus, minus = (np.expm1((s * 2j * wd - decay) * window) / (s * 2j * wd - decay) for s in (1, -1))
    cosine, sine = (plus + minus) / 2, (plus - minus) / 2j
    return ((1 + q**2) / 2 * flat + (1 - q**2) / 2 * cosine + q * sine).real / window


def energies(sigma: np.ndarray, z: np.ndarray, radius: np.ndarray, window: float, p: Membranes) -> np.ndarray:
    """The energy (n,) of membranes with these sigma, z and radius (n,) over a window (seconds), as `p.score` says."""
    if p.score == "printed":
        return _summed(sigma, z, radius, window, p)
    weight, knots = _weights(), _knots(radius)
    factor = np.empty((len(knots), ORDERS))
    for row, knot in zip(factor, knots, strict=True):
        w = angular_speed(float(knot), p)
        row[:] = (weight * (mean_square(w, window, p.fading) if p.score == "mean-square" else w**2 / 2)).sum(axis=1)
    return strength(sigma, z) ** 2 * radius**4 * (_power(z) * _between(knots, factor, radius)).sum(axis=1)


def energies_in_time(
    sigma: np.ndarray, z: np.ndarray, radius: np.ndarray, times: np.ndarray, p: Membranes
) -> np.ndarray:
    """Square of the displacement summed over each membrane (n, times), at single times."""
    weight, knots = _weights(), _knots(radius)
    swing = np.stack([oscillation(angular_speed(float(knot), p), times, p.fading) ** 2 for knot in knots])
    factor = np.einsum("mn,kmnt->kmt", weight, swing)
    power, found = _power(z), np.zeros((len(z), len(times)))
    at, share = _places(knots, radius)
    for knot in range(len(knots)):
        weight_here = np.where(at == knot, 1 - share, 0.0) + np.where(at + 1 == knot, share, 0.0)
        mine = np.flatnonzero(weight_here)
        found[mine] += weight_here[mine, None] * (power[mine] @ factor[knot])
    return (strength(sigma, z) ** 2 * radius**4)[:, None] * found


def _weights() -> np.ndarray:
    """What the square of each mode's swing (orders, roots) counts for."""
    table = modes()
    return table.area * table.radial**2


def _knots(radius: np.ndarray) -> np.ndarray:
    return np.linspace(radius.min(), radius.max(), KNOTS if np.ptp(radius) > 0 else 1)


def _power(z: np.ndarray) -> np.ndarray:
    cosine, sine = angular(z)
    return cosine**2 + sine**2


def _places(knots: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The knot below each value, and how far it is on the way to the next."""
    if len(knots) == 1:
        return np.zeros(len(values), int), np.zeros(len(values))
    at = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, len(knots) - 2)
    return at, (values - knots[at]) / (knots[at + 1] - knots[at])


def _between(knots: np.ndarray, table: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rows of a table (knots, ...) at values between the knots."""
    at, share = _places(knots, values)
    following = np.minimum(at + 1, len(knots) - 1)
    return (1 - share)[:, None] * table[at] + share[:, None] * table[following]


def _summed(sigma: np.ndarray, z: np.ndarray, radius: np.ndarray, window: float, p: Membranes) -> np.ndarray:
    """Sum over times and points of |u|, as printed: tabulated over z and radius, of which S is a factor."""
    from scipy.interpolate import RegularGridInterpolator

    zs = np.geomspace(z.min() * 0.999, z.max() * 1.001, 64)
    radii = np.linspace(radius.min() - 1e-9, radius.max() + 1e-9, 5)
    times = np.linspace(0, window, STEPS)
    theta = np.arange(TURN) * (2 * np.pi / TURN)
    unit = strength(np.ones(1), np.ones(1))[0]
    table = np.empty((len(zs), len(radii)))
    for k, radius_here in enumerate(radii):
        r = radius_here * (np.arange(RING) + 0.5) / RING
        for i, z_here in enumerate(zs):
            scale = unit / float(strength(np.ones(1), np.array([z_here]))[0])
            table[i, k] = scale * np.abs(displacement(1.0, float(z_here), float(radius_here), r, theta, times, p)).sum()
    looked_up = RegularGridInterpolator((np.log(zs), radii), table / unit)
    return strength(sigma, z) * looked_up(np.stack([np.log(z), radius], axis=1))
