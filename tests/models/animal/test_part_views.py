"""The view of a part from its outline: silhouettes compared apart from a similarity, and the view of a known body."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import angle_between, looking
from ipcli.geometry.part_masks import framed, render
from ipcli.measurements.part_images import pixels_of
from ipcli.models.animal import part_views
from ipcli.models.animal.by_parts import spacing_of, spread
from ipcli.models.animal.part_views import PartOutline, Silhouette
from tests.fixtures import limbs


def hook(turn=0.0, scale=1.0, shift=(0.0, 0.0)):
    """Points all over a bent strip."""
    u, v = np.mgrid[-3:3:0.04, -2:4:0.04].reshape(2, -1)
    u, v = (c[((np.abs(u) < 2) & (np.abs(v) < 0.7)) | ((np.abs(u - 1.4) < 0.6) & (v > 0) & (v < 3))] for c in (u, v))
    c, s = np.cos(turn), np.sin(turn)
    return scale * np.stack([c * u - s * v, s * u + c * v], axis=1) + shift


def test_a_silhouette_knows_its_middle_and_area_and_no_hole():
    points = np.random.default_rng(0).uniform([-3.0, 1.0], [1.0, 3.0], (20000, 2))
    found = Silhouette.of(points[np.abs(points - [-1, 2]).max(axis=1) > 0.3], 0.1)
    assert found.middle == pytest.approx([-1, 2], abs=0.03)
    assert found.extent**2 == pytest.approx(8.0, rel=0.05)


def test_a_similarity_does_not_matter_but_another_shape_does():
    one, two = Silhouette.of(hook(), 0.06), Silhouette.of(hook(scale=7.0, shift=(9, -4)), 0.42)
    assert one.overlap(two) > 0.95
    assert one.overlap(Silhouette.of(hook() * [1, 0.6], 0.06)) < 0.8
    assert one.overlap(Silhouette.of(hook(turn=0.5), 0.06)) < 0.75


@pytest.mark.parametrize("turn", [0.7, -2.1])
def test_the_turn_within_the_image_is_found(turn):
    one, two = Silhouette.of(hook(), 0.06), Silhouette.of(hook(turn=turn), 0.06)
    angle, left = one.turned(two)
    assert np.angle(np.exp(1j * (angle - turn))) == pytest.approx(0, abs=1.5 * 2 * np.pi / part_views.BINS)
    assert left < 0.6 * one.turned(Silhouette.of(hook() * [1, 0.4], 0.06))[1]


def test_a_rolled_camera_sees_the_image_turned():
    points, rotation = np.random.default_rng(0).normal(size=(9, 3)), looking(30, 20)
    seen, turned = points @ rotation[:2].T, points @ part_views._rolled(rotation, 0.3)[:2].T
    assert turned == pytest.approx(seen @ np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]]))


def test_close_rotations_count_as_one():
    turns = np.array([looking(a, 10.0) for a in (0, 10, 30, 35, 90)])
    assert [int(np.argmin([angle_between(r, t) for t in turns])) for r in part_views.distinct(turns, 3)] == [0, 2, 4]
    assert len(part_views.distinct(turns, 2)) == 2


def test_the_view_of_a_known_body_is_found(monkeypatch):
    monkeypatch.setattr(part_views, "DIRECTIONS", 300)
    monkeypatch.setattr(part_views, "REFINED", 4)
    vertices, faces, labels = limbs.mesh(0.08)
    rotation, side = looking(40, 15), 0.5 * spacing_of(vertices, faces)
    camera, shape = framed(vertices, rotation, 160)
    seen, _ = render(vertices, faces, labels, camera, shape)
    outline = PartOutline(spread(vertices, faces), side, Silhouette.of(pixels_of(seen > 0) / camera.scale, side))
    found = outline.views(3)
    assert angle_between(found[0], rotation) < 6
    assert outline.overlap(found[0]) > 0.9 > outline.overlap(looking(100, 15))
