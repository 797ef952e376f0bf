"""The plain primal-dual method on a problem with a known solution."""

import numpy as np
import pytest

from ipcli.inverse.regularize.operators import gradient, gradient_adjoint
from ipcli.inverse.regularize.pdhg import pdhg
from ipcli.inverse.regularize.proximal import project_balls, squared_deviations


@pytest.mark.parametrize("relaxation", [1.0, 1.8])
def test_pdhg_denoises_a_step_to_the_closed_form_and_its_dual_certifies_it(relaxation):
    """TV + lambda |x - d|^2 / 2: each side of n columns moves by 1 / (lambda n), and div p = lambda (x - d)."""
    n, lam = 6, 0.25
    d = np.where(np.arange(2 * n) < n, 0.0, 3.0) + np.zeros((4, 1))
    x, p = pdhg(
        gradient,
        gradient_adjoint,
        lambda x, tau: squared_deviations(x, d[None], np.full((1, *d.shape), lam), tau),
        lambda p, sigma: project_balls(p, 1.0, (1, 1)),
        np.zeros_like(d),
        np.zeros((2, *d.shape)),
        tau=0.34,
        sigma=0.34,
        iterations=800,
        relaxation=relaxation,
    )
    loss = 1 / (lam * n)
    np.testing.assert_allclose(x, np.where(d > 0, 3 - loss, loss), atol=1e-6)
    np.testing.assert_allclose(-gradient_adjoint(p), lam * (x - d), atol=1e-6)
