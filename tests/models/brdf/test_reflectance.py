"""Reflectance maps: closed forms, brute force, gradients."""

import numpy as np
import pytest

from ipcli.models.brdf import light, reflectance
from ipcli.models.brdf.materials import Conductor, Plastic

METAL = Conductor((1.22, 0.96, 0.66), (7.37, 6.69, 5.65), 0.35)


class Matte:
    def __call__(self, towards, view):
        return np.where(towards[..., 2:] > 0, np.full(3, 0.6) / np.pi, 0)


def normals(count, seed=0):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n[:, 2] = np.abs(n[:, 2]) + 0.2
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_frames_are_rotations_that_take_the_normal_up():
    n = normals(50)
    f = reflectance.frames(n)
    np.testing.assert_allclose(f @ np.swapaxes(f, 1, 2), np.tile(np.eye(3), (50, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", f, n), np.tile([0, 0, 1.0], (50, 1)), atol=1e-12)


def test_even_light_shows_the_albedo_everywhere():
    even = light.Light(np.ones((light.DIRECTIONS, 3)))
    chart = reflectance.charts(Matte(), [even])[0]
    np.testing.assert_allclose(chart, 0.6, rtol=0.01)


@pytest.mark.parametrize("brdf", [METAL, Plastic((0.5, 0.3, 0.2), 1.5, 0.3)])
def test_a_map_is_the_integral_over_the_light(brdf):
    """Against plain Monte Carlo over the sphere with the radiance interpolated where the rays go."""
    key = np.array([0.4, 0.5, 0.77])

    def radiance(d):
        return 0.2 + np.exp(20 * (d @ key / np.linalg.norm(key) - 1))

    lit = light.Light(np.repeat(radiance(light.sphere())[:, None], 3, axis=1))
    n = normals(50)
    ours = (reflectance.transfer(brdf, n, light.sphere()) * lit.radiance).sum(axis=1)
    d = light.sphere(60_000)
    f = reflectance.frames(n)
    brute = []
    for frame in f:
        local = d @ frame.T
        view = np.broadcast_to(frame[:, 2], local.shape)
        brute.append(
            (brdf(local, view) * np.clip(local[:, 2:], 0, None) * radiance(d)[:, None]).mean(axis=0) * 4 * np.pi
        )
    error = np.abs(ours - brute) / np.abs(brute)
    assert np.median(error) < 0.02
    assert error.max() < 0.05


def test_a_chart_is_its_transfers_and_asks_once_for_the_albedo(monkeypatch):
    asked, albedo = [], reflectance.directional_albedo
    monkeypatch.setattr(reflectance, "directional_albedo", lambda *words: asked.append(words) or albedo(*words))
    lit = light.Light(np.abs(np.random.default_rng(0).normal(size=(light.DIRECTIONS, 3))))
    (chart,) = reflectance.charts(METAL, [lit], side=9, coarse=9)
    assert len(asked) == 1
    for row, normal in zip(chart, reflectance.chart_normals(9), strict=True):
        alone = np.einsum("ndc,dc->nc", reflectance.transfer(METAL, normal, light.sphere()), lit.radiance)
        np.testing.assert_allclose(row, alone, rtol=1e-12)


def test_a_point_light_on_a_matte_ball_is_the_cosine():
    towards = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    directions = light.sphere()
    radiance = np.zeros((len(directions), 3))
    nearest = int((directions @ towards).argmax())
    radiance[nearest] = len(directions) / (4 * np.pi)
    n = normals(40)
    seen = (reflectance.transfer(Matte(), n, directions) * radiance).sum(axis=1)[:, 0]
    np.testing.assert_allclose(seen, 0.6 / np.pi * np.clip(n @ directions[nearest], 0, None), rtol=0.01, atol=1e-4)


@pytest.mark.parametrize("kind", ["harmonics", "chart"])
def test_the_slopes_of_a_map_are_its_derivatives(kind):
    rng = np.random.default_rng(3)
    if kind == "harmonics":
        reflects = reflectance.Harmonics(rng.normal(size=9))
    else:
        axis = np.linspace(-1, 1, 65)
        reflects = reflectance.Chart(np.cos(2 * axis[:, None]) + np.sin(3 * axis + axis[:, None]), 1.7)
    n = normals(30)
    n = n[n[:, 2] > 0.3]
    value, gradient = reflects.slopes(n)
    step = 1e-6 * rng.normal(size=n.shape)
    np.testing.assert_allclose(reflects.slopes(n + step)[0] - value, (gradient * step).sum(axis=1), atol=1e-10)
