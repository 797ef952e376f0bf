"""BRDFs: reciprocity, energy, closed forms, the same material by two independent fits."""

from pathlib import Path

import numpy as np
import pytest

from ipcli.io.materials import measured
from ipcli.models.brdf import materials, reflectance

METAL = materials.Conductor((1.22, 0.96, 0.66), (7.37, 6.69, 5.65), 0.3)
PLASTIC = materials.Plastic((0.6, 0.3, 0.1), 1.5, 0.2)
COAT = materials.Abc((0.1, 0.1, 0.1), (50.0, 40.0, 30.0), 1000.0, 0.9, 1.6)


def hemisphere(count, seed=0):
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("brdf", [METAL, PLASTIC, COAT])
def test_light_and_view_can_be_exchanged(brdf):
    light, view = hemisphere(500, 1), hemisphere(500, 2)
    np.testing.assert_allclose(brdf(light, view), brdf(view, light), rtol=1e-9)


@pytest.mark.parametrize("brdf", [METAL, PLASTIC, COAT])
def test_nothing_comes_from_below_the_surface(brdf):
    light, view = hemisphere(50, 1), hemisphere(50, 2)
    assert (brdf(light * [1, 1, -1], view) == 0).all()


def test_a_surface_gives_no_more_light_than_it_gets():
    for brdf in (METAL, PLASTIC):
        albedo = reflectance.directional_albedo(brdf, hemisphere(20))
        assert (albedo > 0).all()
        assert (albedo < 1.02).all()


def test_the_albedo_of_a_matte_surface_is_its_albedo():
    class Matte:
        def __call__(self, light, view):
            return np.where(light[..., 2:] > 0, np.array([0.5, 0.2, 0.9]) / np.pi, 0)

    np.testing.assert_allclose(
        reflectance.directional_albedo(Matte(), hemisphere(5)), np.tile([0.5, 0.2, 0.9], (5, 1)), rtol=2e-3
    )


def test_fresnel_at_normal_incidence_is_the_closed_form():
    eta, kappa = np.array([0.5, 2.9]), np.array([3.0, 2.9])
    closed = ((eta - 1) ** 2 + kappa**2) / ((eta + 1) ** 2 + kappa**2)
    np.testing.assert_allclose(materials.conductor_fresnel(np.array(1.0), eta, kappa), closed, rtol=1e-12)
    np.testing.assert_allclose(materials.dielectric_fresnel(np.array(0.0), 1.5), 1.0)


def test_half_and_difference_angles_come_back_to_the_directions():
    light, view = hemisphere(200, 1), hemisphere(200, 2)
    half, difference = materials.half_difference(light, view)
    middle = (light + view) / np.linalg.norm(light + view, axis=1, keepdims=True)
    np.testing.assert_allclose(half[:, 2], middle[:, 2], atol=1e-12)
    np.testing.assert_allclose(difference[:, 2], (light * middle).sum(axis=1), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(difference, axis=1), 1, atol=1e-12)


def test_a_table_gives_back_the_material_it_was_filled_with():
    n = materials.MERL_SHAPE
    theta_h = ((np.arange(n[0]) + 0.5) / n[0]) ** 2 * np.pi / 2
    lobe = np.broadcast_to(np.cos(theta_h)[:, None, None, None], (*n, 3))
    light, view = hemisphere(300, 1), hemisphere(300, 2)
    half = materials.half_difference(light, view)[0]
    np.testing.assert_allclose(materials.Table(lobe)(light, view)[:, 0], half[:, 2], atol=0.02)


@pytest.mark.real
@pytest.mark.parametrize("name", ["aluminium", "brass", "pvc", "red-plastic"])
def test_network_and_abc_fit_of_a_measured_material_agree(real_data, name):
    folder: Path = real_data("brdf/nbrdf_merl")
    network = materials.Network(measured.read_network(folder / "merl_nbrdf_100.npz", name))
    abc = materials.Abc(**measured.read_abc(folder / "merl_sgd_abc.json", name))
    up = np.array([[0.0, 0.0, 1.0]])
    a, b = (reflectance.directional_albedo(brdf, up)[0, 0] for brdf in (network, abc))
    assert abs(a / b - 1) < 0.25
