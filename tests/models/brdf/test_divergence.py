"""Itakura-Saito: never negative, zero for equals, the mean its centroid in the order that is not printed."""

import numpy as np

from ipcli.models.brdf import autoencoder, divergence
from ipcli.models.brdf.parameters import Coding


def test_it_is_a_divergence_of_equal_scale():
    rng = np.random.default_rng(0)
    a, b = rng.uniform(0.01, 1, (2, 50, 6))
    assert (divergence.itakura_saito(a, b) > 0).all()
    np.testing.assert_allclose(divergence.itakura_saito(a, a), 0, atol=1e-12)
    np.testing.assert_allclose(divergence.itakura_saito(3 * a, 3 * b), divergence.itakura_saito(a, b), rtol=1e-9)
    np.testing.assert_allclose(divergence.itakura_saito(np.array([0.5]), np.array([0.25])), 1 - np.log(2))


def test_the_arithmetic_mean_is_the_centroid_of_the_fixed_order_only():
    h = np.random.default_rng(1).uniform(0.05, 1, (200, 1))
    candidates = np.linspace(0.05, 1, 2000)
    fixed = [divergence.itakura_saito(h, np.array([s])).sum() for s in candidates]
    printed = [divergence.itakura_saito(np.array([s]), h).sum() for s in candidates]
    assert abs(candidates[np.argmin(fixed)] - h.mean()) < 1e-3
    assert abs(candidates[np.argmin(printed)] - 1 / (1 / h).mean()) < 1e-3


def test_patches_are_nearest_to_the_material_they_are_of():
    rng = np.random.default_rng(2)
    bases = [rng.normal(size=(2, 10)) for _ in range(2)]

    def of(basis, count=60):
        return rng.normal(size=(count, 2)) @ basis

    looks = []
    for basis in bases:
        taught = autoencoder.in_batches(of(basis, 200))
        coder = autoencoder.learn(taught, Coding(units=(5,), sparsity=0.01, iterations=60), rng)
        looks.append(divergence.look(coder, taught, [of(basis) for _ in range(4)]))
    for index, basis in enumerate(bases):
        for patches in (of(basis) for _ in range(5)):
            far = [one.far(patches, "fixed") + one.far(patches, "error") for one in looks]
            assert np.argmin(far) == index
