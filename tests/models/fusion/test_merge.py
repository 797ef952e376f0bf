"""The merge of fused maps against the surface they were cast from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import NoSolution, ParameterError
from ipcli.geometry.cameras import transform
from ipcli.geometry.surface import normals
from ipcli.measurements.views import View
from ipcli.models.fusion.checks import merge_warnings
from ipcli.models.fusion.merge import FusedMap, Glance, confirmed, depth_noise, merge, neighbours
from ipcli.models.fusion.parameters import Merge
from tests.fixtures.fusion_scenes import WALL, distance, pose_at, scene

NOISE = 0.004  # of the maps, which are fused already


def fused(view: View, noise=NOISE) -> FusedMap:
    """A map as the fusion leaves it: smooth normals, even confidence."""
    smooth = normals(view.truth, view.intrinsics)
    ones = np.ones(view.depth.shape, np.float32)
    even = np.full(view.depth.shape, noise, np.float32)
    return FusedMap(
        view.depth, ones, ones.astype(np.uint16), smooth, even, view.intrinsics, view.cam_from_world, view.image
    )


def maps(k=6, noise=NOISE, **facts):
    return [fused(view, noise) for view in scene(k, noise=noise, holes=0.02, **facts)]


SETTINGS = Merge(tolerance=4.0)


def test_the_cloud_lies_on_the_surface_nearer_than_the_maps_do():
    cloud = merge(maps(), SETTINGS)
    single = scene(6, noise=NOISE)[0]
    noise = np.nanmedian(np.abs(single.depth - single.truth))
    assert np.median(distance(cloud.points.position)) < 0.6 * noise
    assert cloud.points.views.min() >= 3
    assert cloud.points.views.max() == 6
    np.testing.assert_allclose(np.linalg.norm(cloud.points.normal, axis=1), 1, atol=1e-6)
    wall = distance(cloud.points.position) < 0.01
    facing = -cloud.points.normal @ (WALL / np.linalg.norm(WALL))
    assert np.median(facing[wall]) > 0.99


def test_exact_maps_give_an_exact_cloud_with_nearly_all_of_the_surface():
    """Planes through pixels make the rounding to pixels free on a slanted wall."""
    exact = [replace(m, depth=view.truth) for m, view in zip(maps(), scene(6), strict=True)]
    cloud = merge(exact, Merge(agree=1, relative=1e-4))
    assert np.median(distance(cloud.points.position)) < 1e-5
    assert cloud.counts[:, 1].sum() > 0.9 * cloud.counts[:, 0].sum()


def test_a_floater_that_one_map_sees_is_dropped_and_counted():
    sound = maps()
    depth = sound[2].depth.copy()
    depth[20:26, 10:16] = 1.2
    planted = [*sound[:2], replace(sound[2], depth=depth), *sound[3:]]
    cloud = merge(planted, SETTINGS)
    assert distance(cloud.points.position).max() < 0.1
    assert cloud.counts[2, 2] >= merge(sound, SETTINGS).counts[2, 2] + 25
    alone = merge(planted, replace(SETTINGS, agree=0, neighbours=1, tolerance=1e9))
    assert distance(alone.points.position).max() > 0.5  # the check would see it


def test_what_stands_before_a_point_is_no_contradiction():
    """Of two maps that see the wall and one that has the ball before it."""
    own, second = maps(2, noise=1e-4, seed=3)
    covered = replace(second, depth=second.depth * np.float32(0.5))
    assert confirmed(own, [second, covered], Merge(agree=1))[1] == confirmed(own, [second], Merge(agree=1))[1]


def test_surfaces_that_face_another_way_do_not_agree():
    own, other = maps(2, noise=1e-4)
    turned = replace(other, normals=-other.normals)
    assert confirmed(own, [other], Merge(agree=1))[1][1] > 0 == confirmed(own, [turned], Merge(agree=1))[1][1]


def test_a_motion_of_the_world_moves_the_cloud_alike():
    motion = pose_at((3.0, -2.0, 5.0), 0.7) @ np.array(
        [[1, 0, 0, 0], [0, 0.6, -0.8, 0], [0, 0.8, 0.6, 0], [0, 0, 0, 1]]
    )
    still = maps(4)
    moving = [replace(m, cam_from_world=m.cam_from_world @ np.linalg.inv(motion)) for m in still]
    a, b = merge(still, SETTINGS), merge(moving, SETTINGS)
    np.testing.assert_array_equal(a.counts, b.counts)
    np.testing.assert_allclose(transform(motion, a.points.position), b.points.position, atol=1e-9)
    np.testing.assert_allclose(a.points.normal @ motion[:3, :3].T, b.points.normal, atol=1e-9)
    np.testing.assert_array_equal(a.points.views, b.points.views)


def test_a_larger_scale_of_length_gives_the_same_cloud_larger():
    def large(m):
        pose = m.cam_from_world.copy()
        pose[:3, 3] *= 1024
        return replace(m, depth=m.depth * 1024, noise=m.noise * 1024, cam_from_world=pose)

    a, b = merge(maps(3), SETTINGS), merge([large(m) for m in maps(3)], SETTINGS)
    np.testing.assert_allclose(1024 * a.points.position, b.points.position, rtol=1e-9)
    assert b.spacing == pytest.approx(1024 * a.spacing)


def test_the_mean_is_drawn_to_what_is_certain_and_confidences_add_up():
    near, far = maps(2, noise=1e-4)
    certain = replace(near, confidence=near.confidence * 3, depth=near.depth * np.float32(1.001))
    points, _ = confirmed(certain, [far], Merge(agree=1))
    alone, _ = confirmed(certain, [certain], Merge(agree=1))
    share = np.median(distance(points.position)) / np.median(distance(alone.position))
    assert share == pytest.approx(0.9, abs=0.04)  # 3^2 : 1
    np.testing.assert_array_equal(points.confidence, 4)
    np.testing.assert_array_equal(points.views, 2)


def test_cells_of_a_coarse_grid_hold_one_point_each():
    cloud = merge(maps(3), replace(SETTINGS, spacing=0.1))
    fine = merge(maps(3), SETTINGS)
    assert 20 < len(cloud.points.position) < len(fine.points.position) / 5
    assert np.median(distance(cloud.points.position)) < 0.01
    assert cloud.spacing == 0.1
    with pytest.raises(ParameterError, match="cells along an axis"):
        merge(maps(3), replace(SETTINGS, spacing=1e-9))


def test_neighbours_are_those_that_look_at_the_same_place_from_near_by():
    places = np.stack([Glance.at(m).looks_at for m in maps(6)])
    assert neighbours(places, 0, 2) == [1, 2]
    assert set(neighbours(places, 3, 9)) == {0, 1, 2, 4, 5}


def test_without_enough_maps_that_agree_there_is_no_solution():
    with pytest.raises(NoSolution, match="2 maps, and .* by 2 others: give more, or lower --agree"):
        merge(maps(2), SETTINGS)


def warned(*given, settings=SETTINGS):
    cloud = merge(given, settings)
    names = [f"map {k}" for k in range(len(given))]
    return merge_warnings(names, cloud.cam_from_world, cloud.depths, cloud.counts)


def test_sound_maps_are_merged_without_a_word():
    assert warned(*maps()) == []


def test_a_map_given_twice_is_told():
    one, two, *_ = maps()
    (words,) = warned(one, two, replace(one), settings=Merge(agree=1))
    assert words.startswith("map 0 and map 2 have one and the same camera")


def test_a_map_in_another_unit_is_told():
    *sound, last = maps()
    pose = last.cam_from_world.copy()
    pose[:3, 3] *= 1000
    (words,) = warned(*sound, replace(last, depth=1000 * last.depth, noise=1000 * last.noise, cam_from_world=pose))
    assert words.startswith("map 5 sees its surface")
    assert words.endswith("another unit?")


def test_a_map_whose_pose_does_not_fit_is_told():
    *sound, last = maps()
    pose = last.cam_from_world.copy()
    pose[:3, 3] += [0, 0, 3]
    (words,) = warned(*sound, replace(last, cam_from_world=pose))
    assert words.startswith("map 5: only 0.")


def test_noise_of_disparities_grows_with_the_square_of_the_depth():
    depth = np.array([[1.0, 2.0, 4.0, np.nan]], np.float32)
    scale = 1.4826 * 0.1
    even = depth_noise(depth, np.array([0.1, np.nan]), inverse=False)[0, :3]
    np.testing.assert_allclose(even, scale, rtol=1e-6)
    np.testing.assert_allclose(
        depth_noise(depth, np.array([0.1]), inverse=True)[0, :3], scale * np.array([0.25, 1, 4]), rtol=1e-6
    )
    assert (depth_noise(depth, np.array([np.nan]), inverse=False)[0, :3] > 0).all()
