"""Solids from their own picture: light is found, the surface beats the balloon, sizes and colours do not matter."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.models.brdf import evaluation, grid, parameters, solid, surfaces

LIGHT = np.array([0.45, -0.25, 0.3, 0.35, 0.03, 0, 0, 0.05, 0.02])


def potato(side=120, seed=2):
    rng = np.random.default_rng(seed)
    body = surfaces.ellipsoid(np.array([0.85, 0.6, 0.45]))
    return surfaces.march(surfaces.bumpy(body, rng.normal(0, 3, (4, 3)), rng.uniform(0, 6, 4), 0.08), side)


def picture_of(made, coefficients=LIGHT, albedo=None):
    from ipcli.models.brdf.reflectance import Harmonics

    shade = np.zeros(made.mask.shape)
    shade[made.mask] = np.maximum(Harmonics(coefficients).slopes(made.normals[made.mask])[0], 0)
    return shade[..., None] * (np.ones(3) if albedo is None else albedo)


def error(z, made):
    return evaluation.normal_error(
        grid.normals(np.nan_to_num(z), made.mask), made.normals, evaluation.inside(made.mask)
    )


def modelled(colour, made, side=56):
    small = solid.pictured(colour, made.mask, side)
    shape = solid.solid(small, parameters.Solid())
    return grid.inflate(made.mask) + solid.enlarge(shape.height - small.inflated, small.grid.mask, made.mask), shape


def test_harmonics_are_recovered_from_a_ball():
    rng = np.random.default_rng(0)
    n = rng.normal(size=(2000, 3))
    n[:, 2] = np.abs(n[:, 2])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    from ipcli.models.brdf.reflectance import Harmonics

    values = Harmonics(LIGHT).slopes(n)[0]
    values[:100] += 2.0  # a highlight
    np.testing.assert_allclose(solid.fit_harmonics(values, n, 1e-6).slopes(n)[0][100:], values[100:], atol=0.02)


def test_a_potato_is_modelled_better_than_its_balloon():
    made = potato()
    z, shape = modelled(picture_of(made), made)
    assert shape.omega == 1.0
    assert error(z, made) < 0.75 * error(grid.inflate(made.mask), made)


def test_brightness_of_the_picture_does_not_matter():
    made = potato()
    a, b = (modelled(k * picture_of(made), made)[0] for k in (1.0, 0.13))
    np.testing.assert_allclose(a[made.mask], b[made.mask], atol=1e-6)


def test_a_mirrored_picture_gives_the_mirrored_surface():
    from dataclasses import replace

    made = potato()
    colour = picture_of(made)
    flipped = replace(made, mask=made.mask[:, ::-1], normals=made.normals[:, ::-1] * [-1, 1, 1])
    a, b = modelled(colour, made)[0], modelled(colour[:, ::-1], flipped)[0]
    difference = np.abs(a - b[:, ::-1])[made.mask]
    assert (
        np.percentile(difference, 95) < 0.35
    )  # of 60 px: factorisations differ in their order, and so do step lengths


def test_surfaces_are_weighed_by_their_energies():
    made = potato(60)
    shape = modelled(picture_of(made), made)[1]
    other = replace(shape, height=shape.height + 1, energy=1.1 * shape.energy)
    mean = solid.averaged((other, shape), 0.1)
    np.testing.assert_allclose(mean.height - shape.height, 1 / (1 + np.e))
    assert mean.energy == shape.energy


def test_a_weight_of_the_shading_that_is_given_is_kept():
    made = potato(60)
    small = solid.pictured(picture_of(made), made.mask, 40)
    assert solid.solid(small, parameters.Solid(), omega=0.25).omega == 0.25


def test_two_colours_of_paint_are_told_from_shading():
    made = potato()
    stripes = np.where((np.arange(made.mask.shape[1]) // 15 % 2)[None, :, None] == 0, [0.9, 0.3, 0.2], [0.2, 0.3, 0.5])
    colour = picture_of(made, albedo=stripes)
    small = solid.pictured(colour, made.mask, 56)
    painted = solid.solid(small, parameters.Solid())
    blind = solid.solid(small, parameters.Solid(albedos=1))
    assert len(np.unique(np.round(painted.albedo, 6))) >= 2
    assert painted.residual < 0.6 * blind.residual


@pytest.mark.parametrize("shape", [(90, 60), (61, 121)])
def test_what_is_enlarged_keeps_its_slopes(shape):
    mask = np.ones(shape, bool)
    small_mask = np.ones((shape[0] // 3, shape[1] // 3), bool)
    columns = np.nonzero(small_mask)[1]
    grown = solid.enlarge(0.4 * columns, small_mask, mask)
    slopes = np.diff(grown, axis=1)[:, 12:-12]  # the edge is held, as a spline ends
    np.testing.assert_allclose(slopes, 0.4, rtol=0.03)
