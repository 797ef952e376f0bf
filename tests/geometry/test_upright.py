import numpy as np
import pytest

from ipcli.geometry.upright import Y_UP_FROM, upright


@pytest.mark.parametrize("up", Y_UP_FROM)
def test_the_axis_that_points_up_becomes_y_by_a_rotation(up):
    axis = np.eye(3)["xyz".index(up[-1])] * (-1 if up[0] == "-" else 1)
    assert upright(axis, up).tolist() == [0, 1, 0]
    turn = Y_UP_FROM[up]
    np.testing.assert_array_equal(turn @ turn.T, np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1)


def test_what_is_upright_stays_as_it_is():
    points = np.random.default_rng(0).normal(size=(5, 3))
    assert upright(points, "y") is points
