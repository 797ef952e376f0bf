"""The load (6.4) as printed, and those that are round."""

import numpy as np
import pytest

from ipcli.models.animal import loads
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import Inflation


def strip(half=12, length=160, turn=0.0, size=200):
    v, u = np.mgrid[:size, :size] - (size - 1) / 2
    along, across = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    return (np.abs(across) < half) & (np.abs(along) < length / 2)


def section_error(load):
    """Root mean square distance of a strip's section, scaled to its circle, from the circle."""
    profile = inflate(strip(half=30, length=190), Inflation(load=load, triangles=6000)).picture[:, 99]
    across = (np.arange(200) - 99.5) / 30
    inside = np.abs(across) < 0.97
    circle = np.sqrt(1 - across[inside] ** 2)
    return np.sqrt(np.mean((profile[inside] / profile.max() - circle) ** 2))


def test_f_and_h_are_distances_to_rim_and_through_the_axis():
    about = loads.medial(strip(half=12))
    middle = about.rim[99, 60:140]
    assert middle == pytest.approx(np.full(80, 12.0), abs=1)
    ratio = about.rim[88:99, 100] / about.through[88:99, 100]
    assert ((ratio > 0) & (ratio <= 1.1)).all()
    assert (np.diff(ratio) > 0).all()


def test_the_printed_load_is_flatter_at_the_rim_than_a_constant_one_and_the_steep_one_is_round():
    """(6.4) F / h against h / F: the text asks for a surface that grows steeper near the boundary."""
    printed, constant, steep = (section_error(load) for load in ("printed", "constant", "steep"))
    assert printed > constant > 2 * steep
    assert steep < 0.06
