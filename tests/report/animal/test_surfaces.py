"""Pictures of labelled meshes."""

import numpy as np

from ipcli.geometry.orthographic import named
from ipcli.report.animal import surfaces
from tests.fixtures import limbs


def test_a_shaded_mesh_stands_out_from_its_ground_in_its_colour():
    vertices, faces, labels = limbs.mesh(0.06)
    red = np.tile([200.0, 20, 20], (len(faces), 1))
    picture = surfaces.shaded(vertices, faces, red, named("left"), 80)
    body = (picture != surfaces.BEHIND).any(axis=-1)
    assert 0.2 < body.mean() < 0.9
    assert (picture[body][:, 0] > picture[body][:, 1]).all()


def test_all_pictures_of_a_turntable_have_one_size():
    vertices, faces, _ = limbs.mesh(0.06)
    shown = surfaces.turntable(vertices, faces, np.full((len(faces), 3), 128.0), 4, 60)
    assert len({picture.shape for picture in shown}) == 1


def test_borders_lie_between_labels():
    labels = np.array([[1, 1, 2], [1, 1, 2]])
    assert surfaces.borders(labels).tolist() == [[False, False, True]] * 2


def test_an_overlay_marks_the_outline_of_the_model():
    labels, rendered = np.zeros((6, 6), np.int16), np.zeros((6, 6), np.int16)
    rendered[2:4, 2:4] = 1
    shown = surfaces.overlay(labels, rendered, None)
    assert (shown[2, 2] == 20).all()
    assert (shown[0, 0] == surfaces.PAPER).all()
