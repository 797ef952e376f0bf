"""Lights in the documented frame."""

import numpy as np

from ipcli.models.brdf import light


def test_directions_share_the_sphere_equally():
    d = light.sphere()
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1)
    np.testing.assert_allclose(d.mean(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(d.T @ d / len(d), np.eye(3) / 3, atol=1e-3)


def test_probe_directions_follow_the_documented_frame():
    image = np.full((32, 64, 3), 1e-3)
    image[:8] = 1.0  # the sky
    up = light.probe(image).radiance[:, 0]
    directions = light.sphere()
    assert up[directions[:, 1] > 0.8].min() > 100 * up[directions[:, 1] < 0.5].max()
    image = np.full((32, 64, 3), 1e-3)
    image[14:18, 16] = 1.0  # phi = pi / 2: +x
    x = light.probe(image).radiance[:, 0]
    assert directions[x.argmax()] @ [1, 0, 0] > 0.95
    turned = light.probe(image, heading=np.pi / 2).radiance[:, 0]  # phi = pi: +z, to the viewer
    assert directions[turned.argmax()] @ [0, 0, 1] > 0.95
