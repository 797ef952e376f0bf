"""Facts of meshes that are known: boxes and an open one."""

import numpy as np
import pytest
import trimesh

from ipcli.models.animal.soundness import soundness, thickness


def test_a_flat_box():
    box = trimesh.creation.box((4, 3, 0.5))
    facts = soundness(np.asarray(box.vertices), np.asarray(box.faces))
    assert facts["watertight"]
    assert facts["volume"] == pytest.approx(6.0)
    assert facts["thinnest"] == pytest.approx(0.5, rel=1e-3)


def test_an_open_box_is_not_watertight():
    box = trimesh.creation.box()
    assert not soundness(np.asarray(box.vertices), np.asarray(box.faces)[1:])["watertight"]


def test_two_boxes_are_two_pieces():
    two = trimesh.util.concatenate([trimesh.creation.box(), trimesh.creation.box().apply_translation([3, 0, 0])])
    assert soundness(np.asarray(two.vertices), np.asarray(two.faces))["pieces"] == 2


def test_a_single_triangle_has_no_thickness():
    assert np.isnan(thickness(np.eye(3), np.array([[0, 1, 2]]))).all()
