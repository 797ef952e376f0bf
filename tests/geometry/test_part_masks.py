"""Rendered part masks: sizes, occlusion, depth."""

import numpy as np
import pytest
import trimesh

from ipcli.geometry import orthographic as ortho
from ipcli.geometry.part_masks import framed, render


def two_balls():
    """A ball of radius 1 at the origin (part 1) and one of radius 0.5 to its left (part 2)."""
    one, two = trimesh.creation.icosphere(3, 1.0), trimesh.creation.icosphere(3, 0.5)
    vertices = np.concatenate([one.vertices, two.vertices + [0, 2, 0]])
    faces = np.concatenate([one.faces, two.faces + len(one.vertices)])
    return vertices, faces, np.repeat([1, 2], [len(one.faces), len(two.faces)])


def test_what_is_nearer_hides_what_is_behind():
    vertices, faces, labels = two_balls()
    camera, shape = framed(vertices, ortho.of_view("left"), 200)
    seen, depth = render(vertices, faces, labels, camera, shape)
    disc = np.pi * camera.scale**2
    assert (seen == 2).sum() == pytest.approx(disc / 4, rel=0.03)
    assert (seen > 0).sum() == pytest.approx(disc, rel=0.03)
    assert np.nanmin(depth) == pytest.approx(-2.5, abs=0.01)
    behind, _ = render(vertices, faces, labels, *framed(vertices, ortho.of_view("right"), 200))
    assert not (behind == 2).any()


def test_the_frame_leaves_its_margin():
    vertices, faces, labels = two_balls()
    camera, shape = framed(vertices, ortho.of_view("front"), 150, margin=5)
    seen, _ = render(vertices, faces, labels, camera, shape)
    rows, columns = np.nonzero(seen)
    assert columns.min() == pytest.approx(5, abs=1)
    assert columns.max() == pytest.approx(shape[1] - 6, abs=1)
    assert np.ptp(columns) == pytest.approx(150, abs=2)
    assert rows.min() >= 5
