"""Pictures of labelled meshes."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import of_view
from ipcli.report.animal import surfaces
from tests.fixtures import limbs


def test_a_shaded_mesh_stands_out_from_its_ground_in_its_colour():
    vertices, faces, labels = limbs.mesh(0.06)
    red = np.tile([200.0, 20, 20], (len(faces), 1))
    picture = surfaces.shaded(vertices, faces, red, of_view("left"), 80)
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


def test_overlays_are_of_one_size_and_scale():
    small, large = np.zeros((40, 60), np.int16), np.zeros((200, 90), np.int16)
    small[10:30, 20:50] = 1  # 30 pixels across at 10 a unit: 3 units
    large[50:170, 30:60] = 2  # 120 pixels high at 20 a unit: 6
    photo = np.full((200, 90, 3), 200, np.uint8)
    first, second = surfaces.overlays([(small, small, None), (large, large, photo)], np.array([10.0, 20.0]), 264)
    assert first.shape == second.shape
    unit = 264 / ((120 + 2 * surfaces.SPARE) / 20)
    torso = (first == surfaces.colours_of(0)).all(axis=-1).any(axis=0)
    leg = (np.abs(second.astype(float) - (0.6 * 200 + 0.4 * surfaces.colours_of(1))) < 2).all(axis=-1).any(axis=1)
    assert torso.sum() == pytest.approx(3 * unit, abs=4)
    assert leg.sum() == pytest.approx(6 * unit, abs=4)
    assert (first[0, 0] == surfaces.PAPER).all()
    empty = np.zeros((9, 9), np.int16)
    assert surfaces.overlays([(empty, empty, None)], np.ones(1), 30)[0].shape == (30, 30, 3)


def test_an_overlay_marks_the_outline_of_the_model():
    labels, rendered = np.zeros((6, 6), np.int16), np.zeros((6, 6), np.int16)
    rendered[2:4, 2:4] = 1
    shown = surfaces.overlay(labels, rendered, None)
    assert (shown[2, 2] == 20).all()
    assert (shown[0, 0] == surfaces.PAPER).all()
