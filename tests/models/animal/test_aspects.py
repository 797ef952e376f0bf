"""Loads and aspects: round limbs, rotation, scale, completed masks."""

import numpy as np
import pytest

from ipcli.models.animal.aspects import completed, inflate
from ipcli.models.animal.parameters import LOADS, Inflation

TRIANGLES = Inflation(triangles=3000)


def strip(half=12, length=160, turn=0.0, size=200):
    v, u = np.mgrid[:size, :size] - (size - 1) / 2
    along, across = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    return (np.abs(across) < half) & (np.abs(along) < length / 2)


def disc(radius, size=100):
    v, u = np.mgrid[:size, :size] - (size - 1) / 2
    return u**2 + v**2 < radius**2


def test_a_strip_becomes_a_round_limb():
    aspect = inflate(strip(), TRIANGLES)
    profile = aspect.picture[:, 99]
    across = np.arange(200) - 99.5
    exact = np.sqrt(np.maximum(12.0**2 - across**2, 0))
    assert np.abs(profile - exact).max() < 1.2
    assert profile.max() == pytest.approx(12.0, rel=0.03)


def test_a_disc_is_lifted_by_the_root_of_half():
    assert inflate(disc(40), TRIANGLES).picture.max() == pytest.approx(40 / np.sqrt(2), rel=0.02)


@pytest.mark.parametrize(("load", "bending"), [*((load, 0.0) for load in LOADS), ("constant", 0.3)])
def test_turning_a_mask_turns_its_shape(load, bending):
    """The same limb at 0 and at 45 degrees: within 2 % of its volume the same heights, point by point."""
    from scipy.ndimage import map_coordinates

    params = Inflation(load=load, bending=bending, triangles=3000)
    masks = [strip(half=40.3, length=200, turn=t, size=300) for t in (0.0, np.pi / 4)]
    straight, turned = (inflate(mask, params).picture for mask in masks)
    v, u = (np.mgrid[:300, :300] - 149.5) * np.sqrt(0.5)
    back = map_coordinates(turned, [u + v + 149.5, u - v + 149.5], order=1)
    assert np.abs(back - straight).sum() < 0.02 * straight.sum()


@pytest.mark.parametrize(("load", "power"), [("sqrt-poisson", 1), ("steep", 1), ("printed", 2), ("constant", 2)])
def test_only_loads_that_know_the_radius_lift_in_proportion(load, power):
    params = Inflation(load=load)
    small, large = (inflate(disc(r, 140), params).picture.max() for r in (20, 60))
    assert large / small == pytest.approx(3.0**power, rel=0.12)


def test_flatness_divides_the_heights():
    once, half = inflate(disc(30), Inflation()), inflate(disc(30), Inflation(), flatness=2.0)
    assert half.picture == pytest.approx(once.picture / 2)


def test_bending_stiffens():
    heights = [inflate(strip(half=20), Inflation(load="constant", bending=b)).picture.max() for b in (0.0, 0.2, 0.6)]
    assert heights[0] > heights[1] > heights[2] > 0


def test_aspects_are_closed_surfaces():
    import trimesh

    for load in LOADS:
        body = trimesh.Trimesh(*inflate(disc(30), Inflation(load=load)).surface(), process=False)
        assert body.is_watertight
        assert body.volume > 0


def test_a_notch_that_another_part_covers_is_closed_and_a_free_one_is_not():
    whole = strip(half=30, length=160)
    leg = np.zeros_like(whole)
    leg[95:160, 90:104] = True
    own = whole & ~leg
    filled = completed(own, whole | leg)
    assert filled[100:120, 92:102].all()
    assert not completed(own, own)[105:125, 94:100].any()
    assert not filled[150:, 90:104].any()  # the leg itself stays the leg's


def test_a_cut_gets_a_cap_a_quarter_as_deep_as_it_is_long():
    silhouette = strip(half=12)
    own = silhouette.copy()
    own[:, 100:] = False
    added = completed(own, silhouette) & ~own
    columns = np.nonzero(added.any(axis=0))[0]
    assert columns.min() == 100
    assert columns.max() == pytest.approx(100 + 6, abs=2)


def test_completing_does_not_depend_on_how_much_of_the_image_lies_around():
    own = strip(half=9, length=70)
    own[90:110, 95:101] = False
    silhouette = strip(half=30, length=90)
    filled = completed(own, silhouette)
    assert (filled & ~own).any()
    assert (completed(own[60:140, 50:150], silhouette[60:140, 50:150]) == filled[60:140, 50:150]).all()


@pytest.mark.parametrize("load", LOADS)
def test_a_pinhole_changes_nothing(load):
    whole = strip(size=180)
    pierced = whole.copy()
    pierced[90, 80] = False
    params = Inflation(load=load, triangles=600)
    assert inflate(pierced, params).heights == pytest.approx(inflate(whole, params).heights, rel=0.02)
