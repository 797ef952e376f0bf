"""Cameras from single parts: what parts propose, and which proposal is taken."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.geometry.orthographic import angle_between, looking
from ipcli.geometry.raycast import Mesh
from ipcli.measurements.part_images import pixels_of
from ipcli.models.animal import by_parts, part_views, placing
from ipcli.models.animal.parameters import SEARCHES, Inflation, Modelling, Volume
from ipcli.models.animal.part_views import PartOutline, Silhouette
from ipcli.models.animal.whole import PartedSurface
from tests.fixtures import limbs

ASKEW = looking(40.0, 15.0)
QUICK = Modelling(Inflation(triangles=200), Volume(voxels=40, steps=4))


@pytest.fixture(scope="module")
def scene():
    """A true model, its images from the left, from the front and askew, and their cameras."""
    vertices, faces, labels = limbs.mesh(0.07)
    parts = {k: (vertices[faces[labels == k + 1]].reshape(-1, 3), np.empty((0, 3), np.int32)) for k in range(4)}
    surface = PartedSurface(vertices, faces, labels - 1, parts)
    return surface, limbs.shots(("left", "front", "askew"), rotations={"askew": ASKEW})


def test_the_scale_is_the_root_of_the_area(scene):
    _, ((left, camera), *_) = scene
    assert by_parts.scale_of(left, [(left, camera)]) == pytest.approx(camera.scale)


def test_shape_matching_finds_scale_and_shift(scene):
    surface, shots = scene
    image, camera = shots[2]
    side = 0.5 * by_parts.spacing_of(surface.vertices, surface.faces)
    points = by_parts.spread(surface.vertices, surface.faces)
    found = by_parts.shape_matched(image, camera.rotation, points, 1.1 * camera.scale, side)
    assert found.scale == pytest.approx(camera.scale, rel=0.03)
    assert found.shift == pytest.approx(camera.shift, abs=1.5)


def test_the_proposal_is_taken_under_which_the_parts_lie_right(scene, monkeypatch):
    surface, shots = scene
    mirrored = np.diag([1.0, -1.0, -1.0]) @ ASKEW
    proposed = [mirrored, looking(140, 15), looking(44, 12), looking(70, 0)]
    monkeypatch.setattr(by_parts, "to_surface", lambda points, goal: np.zeros(len(points)))
    monkeypatch.setattr(by_parts, "proposals", lambda *rest: proposed)
    found = by_parts.find_camera(shots[2][0], surface, shots[:2], "view")
    assert np.array_equal(found.rotation, proposed[2])
    monkeypatch.setattr(by_parts, "proposals", lambda *rest: [])
    with pytest.raises(NoSolution, match="askew: no part shows enough"):
        by_parts.find_camera(shots[2][0], surface, shots[:2], "twopoint")


def test_a_part_proposes_views_of_itself(scene, monkeypatch):
    monkeypatch.setattr(part_views, "DIRECTIONS", 100)
    monkeypatch.setattr(by_parts, "SAMPLES", 300)
    surface, shots = scene
    image, camera = shots[2]
    whole = replace(image, labels=(image.labels > 0).astype(np.int16))
    vertices, faces = surface.vertices, surface.faces
    side = 0.5 * by_parts.spacing_of(vertices, faces)
    body, skin = Mesh(vertices, faces), np.ones(len(vertices), bool)
    found = {s: by_parts.proposals(whole, 0, body, skin, camera.scale, side, s) for s in SEARCHES[1:]}
    assert [len(found[s]) for s in ("view", "twopoint", "hybrid")] == [by_parts.PROPOSED, 1, by_parts.PROPOSED]
    assert all(np.allclose(r @ r.T, np.eye(3)) and np.linalg.det(r) > 0 for own in found.values() for r in own)
    assert min(angle_between(r, ASKEW) for r in found["view"]) < 15
    shown = Silhouette.of(pixels_of(whole.silhouette) / camera.scale, side)
    outline = PartOutline(by_parts.spread(vertices, faces), side, shown)
    assert outline.overlap(found["hybrid"][0]) > outline.overlap(found["twopoint"][0])  # which does not fix the view
    assert by_parts.proposals(whole, 0, body, ~skin, camera.scale, side, "twopoint") == []  # all of it is a cut
    thin = replace(image, labels=np.zeros((90, 90), np.int16))
    thin.labels[10, 5:80] = 1
    assert by_parts.proposals(thin, 0, body, skin, camera.scale, side, "twopoint") == []


@pytest.mark.parametrize("search", SEARCHES[1:])
def test_images_without_a_view_are_placed_by_the_search_that_was_asked_for(scene, search, monkeypatch):
    _, shots = scene
    asked = []

    def find(image, surface, known, how):
        asked.append((image.name, [other.name for other, _ in known], how))
        assert set(surface.parts) == {0, 1, 2, 3}
        return shots[2][1]

    monkeypatch.setattr(placing.by_parts, "find_camera", find)
    found = placing.placed([image for image, _ in shots], limbs.TREE, replace(QUICK, search=search))
    assert found[2] is shots[2][1]
    assert asked == [("askew", ["left", "front"], search)]
