"""The classifier of materials on features whose posterior is known, and the invariance of its statistics."""

import numpy as np

from ipcli.models.brdf import material, solid


def test_gaussians_of_one_covariance_get_their_own_posterior():
    rng = np.random.default_rng(0)
    centres = np.array([[0, 0], [2, 0], [0, 2.5]])
    labels = rng.integers(0, 3, 6000)
    x = centres[labels] + rng.normal(size=(6000, 2))
    learnt = material.learn(x, labels, 3)
    tried = rng.normal(1, 1, (200, 2))
    density = np.exp(-((tried[:, None] - centres) ** 2).sum(axis=-1) / 2)
    np.testing.assert_allclose(learnt.posterior(tried), density / density.sum(axis=1, keepdims=True), atol=0.06)


def test_held_out_accuracy_never_sees_the_surface_or_the_probe():
    """Features that are the number of the surface tell the material of pictures of known surfaces, and of no others."""
    rng = np.random.default_rng(0)
    surfaces, probes, labels = rng.integers(0, 40, 600), rng.integers(0, 10, 600), None
    of_surface = rng.integers(0, 2, 40)
    labels = of_surface[surfaces]
    features = np.eye(40)[surfaces]
    right, _ = material.accuracy(features, labels, surfaces, probes, np.array([True, False]))
    assert right < 0.75


def test_statistics_do_not_depend_on_exposure():
    rng = np.random.default_rng(1)
    mask = np.ones((60, 60), bool)
    colour = rng.uniform(0.1, 0.9, (60, 60, 3))
    a, b = (material.statistics(solid.pictured(k * colour, mask, 40)) for k in (1.0, 0.2))
    assert len(a) == len(material.STATISTICS)
    np.testing.assert_allclose(a, b, atol=1e-9)
