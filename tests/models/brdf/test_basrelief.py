"""The Bogner-Fox-Schmit element: exact energies, the clamped plate of the textbooks, and a cap from its normals."""

import numpy as np
import pytest

from ipcli.models.brdf import basrelief, evaluation, grid, parameters
from ipcli.models.brdf.energy import factor


def dofs(side, z, z_u, z_v, z_uv):
    x, y = np.meshgrid(np.arange(side, dtype=float), side - 1 - np.arange(side, dtype=float))
    return np.stack([f(x, y) * np.ones_like(x) for f in (z, z_u, z_v, z_uv)], axis=-1).ravel()


@pytest.mark.parametrize("plate", [True, False])
def test_energies_of_cubics_are_exact(plate):
    """z = x^3 + 2 x y^2 + x y on [0, 4]^2: bending and membrane energies by Gauss quadrature of the closed forms."""
    side = 5
    u = dofs(
        side,
        lambda x, y: x**3 + 2 * x * y**2 + x * y,
        lambda x, y: 3 * x**2 + 2 * y**2 + y,
        lambda x, y: 4 * x * y + x,
        lambda x, y: 4 * y + 1,
    )
    k = basrelief.stiffness(np.ones((side, side), bool), 0.0 if plate else 1.0, 1.0 if plate else 0.0)
    t, w = np.polynomial.legendre.leggauss(8)
    x, y = np.meshgrid(2 * t + 2, 2 * t + 2)
    area = 4 * np.outer(w, w)
    bending = (6 * x) ** 2 + 2 * (4 * y + 1) ** 2 + (4 * x) ** 2
    stretching = (3 * x**2 + 2 * y**2 + y) ** 2 + (4 * x * y + x) ** 2
    assert u @ (k @ u) == pytest.approx((area * (bending if plate else stretching)).sum(), rel=1e-10)


def test_a_plane_does_not_bend():
    u = dofs(6, lambda x, y: 2 + 3 * x - y, lambda x, y: 3, lambda x, y: -1, lambda x, y: 0)
    assert np.abs(basrelief.stiffness(np.ones((6, 6), bool), 0.0, 1.0) @ u).max() < 1e-10


def test_a_clamped_plate_sinks_as_the_textbooks_say():
    """Centre deflection .00126 q a^4 / D of a square plate under an even load (Timoshenko)."""
    side = 21
    k = basrelief.stiffness(np.ones((side, side), bool), 0.0, 1.0)
    free = np.zeros((side, side, 4), bool)
    free[1:-1, 1:-1] = True
    free = free.ravel()
    load = np.zeros((side, side, 4))
    load[..., 0] = 1.0  # lumped: slopes get none, by symmetry of neighbouring elements
    u = np.zeros(free.size)
    u[free] = factor(k[free][:, free]).solve(load.ravel()[free])
    centre = u.reshape(side, side, 4)[side // 2, side // 2, 0]
    assert centre / (side - 1) ** 4 == pytest.approx(0.00126, rel=0.01)


def test_a_cap_comes_back_from_its_normals_also_across_a_gap():
    rows, columns = np.indices((61, 61)) - 30
    mask = np.hypot(rows, columns) < 28
    z = np.sqrt(np.maximum(40.0**2 - rows**2 - columns**2, 0))
    n = np.stack([columns / 40, -rows / 40, z / 40], axis=-1)
    n[~mask] = np.nan
    n[20:26, 33:40] = np.nan
    found = basrelief.bas_relief(n, mask, parameters.Plate())
    assert evaluation.height_error(found, z, mask) < 0.15
    assert evaluation.normal_error(grid.normals(np.nan_to_num(found), mask), n, mask) < 0.02
