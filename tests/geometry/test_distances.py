"""Distances between spheres, which are known."""

import numpy as np
import pytest
import trimesh

from ipcli.geometry.distances import apart, overlap


def ball(radius, shift=0.0):
    body = trimesh.creation.icosphere(4, radius)
    return body.vertices + [shift, 0, 0], body.faces


def test_concentric_balls():
    found = apart(ball(1.1), ball(1.0))
    diagonal = 2 * np.sqrt(3)
    assert found.mean == pytest.approx(0.1 / diagonal, rel=0.03)
    assert found.rms == pytest.approx(0.1 / diagonal, rel=0.03)
    assert found.most == pytest.approx(0.1 / diagonal, rel=0.05)
    assert found.outside == pytest.approx(1 - 1 / 1.1**3, abs=0.01)


def test_a_body_is_not_apart_from_itself():
    found = apart(ball(1.0), ball(1.0))
    assert found.most < 1e-6
    assert found.outside == 0


def test_balls_that_do_not_meet_have_nothing_in_common():
    assert overlap(ball(1.0), ball(1.0, 3.0)) == 0


def test_distances_do_not_depend_on_size():
    small, large = apart(ball(1.1), ball(1.0)), apart(ball(11.0), ball(10.0))
    assert large.mean == pytest.approx(small.mean, rel=1e-6)
