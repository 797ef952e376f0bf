"""From masks of an analytic animal to its surface: cameras, carving, rims, closed meshes."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from ipcli.errors import NoSolution
from ipcli.geometry.orthographic import Orthographic, by_angles, of_view
from ipcli.geometry.part_masks import render
from ipcli.models.animal import cameras as cm
from ipcli.models.animal import whole
from ipcli.models.animal.parameters import MERGES, Inflation, Modelling, Volume
from tests.fixtures import limbs

VIEWS = ("left", "right", "front", "back", "top")
QUICK = Modelling(Inflation(triangles=400), Volume(voxels=56, steps=12))


@pytest.fixture(scope="module")
def taken():
    return limbs.shots(VIEWS)


def distance(surface, cameras, truth):
    """Mean symmetric distance over the diagonal; the model's world is that of its first camera."""
    import igl

    vertices, faces, _ = limbs.mesh()
    rows = np.vstack([camera.rotation[:2] for camera in truth])
    offset = np.concatenate([(c.shift - t.shift) / t.scale for c, t in zip(cameras, truth, strict=True)])
    moved = surface.vertices / truth[0].scale + np.linalg.lstsq(rows, offset, rcond=None)[0]
    found = (np.ascontiguousarray(moved, float), surface.faces.astype(np.int64))
    pairs = ((found, (vertices, faces)), ((vertices, faces), found))
    each = [
        np.sqrt(igl.point_mesh_squared_distance(a[0], b[0], np.ascontiguousarray(b[1]))[0]).mean() for a, b in pairs
    ]
    return np.mean(each) / np.linalg.norm(np.ptp(vertices, axis=0))


def test_the_model_is_near_the_truth_and_closed(taken):
    images, truth = zip(*taken, strict=True)
    found = cm.align([i.silhouette for i in images], [t.rotation for t in truth])
    surface = whole.model(images, found, limbs.TREE, QUICK)
    body = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert body.is_watertight
    assert body.body_count == 1
    assert set(surface.parts) == {0, 1, 2, 3}
    assert all(trimesh.Trimesh(*part, process=False).is_watertight for part in surface.parts.values())
    assert distance(surface, found, truth) < 0.008


def test_a_hull_that_leans_far_does_not_make_the_grid_coarse(taken):
    oblique = by_angles(35.0, 10.0)
    images, truth = zip(*limbs.shots(("left", oblique)), strict=True)
    lean = whole.grid_of(images, truth, 56)
    upright = whole.grid_of(*zip(*taken[:3], strict=True), 56)
    assert max(lean.shape) > 1.1 * max(upright.shape)
    assert lean.spacing == pytest.approx(upright.spacing, rel=0.15)


def test_parts_and_rims_beat_the_visual_hull_from_two_silhouettes(taken):
    images, truth = zip(*taken[:4], strict=True)
    found = cm.align([i.silhouette for i in images], [t.rotation for t in truth])
    grid = whole.grid_of(images, found, 56)
    shots = whole.shots_of(images, found, grid)
    hull = np.maximum.reduce([s.sight.silhouette_distance(s.image.silhouette) for s in shots])
    from ipcli.geometry.level_sets import mesh

    vertices, faces = mesh(hull, grid.spacing, grid.origin)
    plain = whole.PartedSurface(vertices, faces, np.zeros(len(faces)))
    ours = whole.model(images, found, limbs.TREE, QUICK)
    assert distance(ours, found, truth) < 0.75 * distance(plain, found, truth)


@pytest.mark.parametrize("merge", MERGES)
def test_every_way_of_merging_gives_a_closed_surface(taken, merge):
    images, truth = zip(*taken[:3], strict=True)
    found = cm.align([i.silhouette for i in images], [t.rotation for t in truth])
    params = replace(QUICK, volume=replace(QUICK.volume, merge=merge))
    surface = whole.model(images, found, limbs.TREE, params)
    assert trimesh.Trimesh(surface.vertices, surface.faces, process=False).is_watertight


def test_the_order_of_the_images_does_not_matter(taken):
    images, truth = zip(*taken[:3], strict=True)
    surfaces = []
    for order in ([0, 1, 2], [0, 2, 1]):
        own = [images[k] for k in order]
        found = cm.align([i.silhouette for i in own], [truth[k].rotation for k in order])
        surfaces.append(whole.model(own, found, limbs.TREE, QUICK))
    volumes = [trimesh.Trimesh(s.vertices, s.faces, process=False).volume for s in surfaces]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-3)


def test_silhouettes_without_a_common_body_have_no_solution(taken):
    (image, camera), (other, second), *_ = taken
    apart = Orthographic(of_view("front"), second.scale, np.array([1e5, 1e5]))
    with pytest.raises(NoSolution, match="in common"):
        whole.grid_of([image, other], [camera, apart], 40)


def test_a_single_view_from_any_angle_is_the_model_of_that_view_turned(taken):
    image = taken[0][0]
    sizes = []
    for view in ("left", "45,0", "60,30"):
        (camera,) = cm.align([image.silhouette], [of_view(view)])
        surface = whole.model([image], [camera], limbs.TREE, QUICK)
        sizes.append(np.ptp(surface.vertices @ camera.rotation.T, axis=0))
    assert sizes[1] == pytest.approx(sizes[0], rel=0.1)
    assert sizes[2] == pytest.approx(sizes[0], rel=0.1)


def test_two_views_across_one_another_are_not_one_line(taken):
    image = taken[0][0]
    cameras = cm.align([image.silhouette] * 2, [of_view("45,0"), of_view("135,0")])
    grid = whole.grid_of([image] * 2, cameras, 40)
    size = grid.spacing * np.array(grid.shape)
    assert size[0] == pytest.approx(size[1], rel=0.1)


def test_masks_that_leave_no_body_have_no_solution(taken):
    image = replace(taken[0][0], labels=np.ones((1, 1), np.int16))
    cameras = cm.align([image.silhouette] * 2, [of_view("left"), of_view("front")])
    with pytest.raises(NoSolution, match="no body"):
        whole.model([image] * 2, cameras, limbs.TREE, QUICK)


def test_seen_by_counts_the_images_that_see_a_vertex(taken):
    images, truth = zip(*taken[:1], strict=True)
    vertices, faces, labels = limbs.mesh()
    surface = whole.PartedSurface(vertices.astype(np.float32), faces.astype(np.int32), (labels - 1).astype(np.int16))
    seen = whole.seen_by(surface, images, truth)
    torso = np.abs(vertices[:, 0]) < 0.3
    assert seen[torso & (vertices[:, 1] > 0.2)].all()
    assert not seen[torso & (vertices[:, 1] < -0.2)].any()


def test_overlap_of_labels():
    seen, rendered = np.array([[1, 1, 0, 2]]), np.array([[1, 0, 0, 1]])
    total, each = whole.overlap(seen, rendered, 3)
    assert total == pytest.approx(1 / 3)
    assert each[:2] == pytest.approx([1 / 3, 0.0])
    assert np.isnan(each[2])


def test_scaling_keeps_what_the_cameras_see(taken):
    images, truth = zip(*taken[:2], strict=True)
    vertices, faces, labels = limbs.mesh()
    surface = whole.PartedSurface(vertices.astype(np.float32), faces.astype(np.int32), labels - 1)
    moved, cameras = whole.scaled(surface, truth, 7.0)
    assert np.ptp(moved.vertices, axis=0).max() == pytest.approx(7.0, rel=1e-5)
    again, _ = render(moved.vertices.astype(float), moved.faces, labels, cameras[0], images[0].labels.shape)
    assert (again != images[0].labels).mean() < 1e-3


def test_where_no_silhouette_holds_a_limb_the_flow_is_short():
    assert {merge: Volume(merge=merge).rounding for merge in MERGES} == {"hull": 20, "clip": 2, "union": 2}
    assert Volume(merge="union", steps=7).rounding == 7
