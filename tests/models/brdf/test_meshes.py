"""A mesh seen from the front: a ball of triangles has the height and normals of a ball, however it is wound."""

import numpy as np
import pytest
import trimesh

from ipcli.models.brdf.meshes import FILL, seen

BALL = trimesh.creation.icosphere(4)


@pytest.mark.parametrize("faces", [BALL.faces, BALL.faces[:, ::-1]])
def test_a_ball_has_the_height_and_normals_of_a_ball(faces):
    made = seen(np.asarray(BALL.vertices), np.asarray(faces), 40, np.eye(3), "ball")
    axis = (np.arange(40) + 0.5) / 20 - 1
    x, y = np.meshgrid(axis / FILL, -axis / FILL)
    inner = x * x + y * y < 0.9
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    np.testing.assert_allclose(made.height[inner], 20 * FILL * z[inner], atol=0.15)
    np.testing.assert_allclose(made.normals[inner], np.stack([x, y, z], axis=-1)[inner], atol=0.02)
    np.testing.assert_array_equal(made.mask, np.isfinite(made.height))
    assert made.mask.mean() == pytest.approx(np.pi / 4 * FILL**2, rel=0.03)


def test_a_turned_box_faces_its_new_side():
    box = trimesh.creation.box((1, 2, 3))
    turn = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])  # its z becomes x
    made = seen(np.asarray(box.vertices), np.asarray(box.faces), 30, turn, "box")
    rows, columns = (np.flatnonzero(made.mask.any(axis=axis)).size for axis in (1, 0))
    assert columns / rows == pytest.approx(1.5, abs=0.1)
