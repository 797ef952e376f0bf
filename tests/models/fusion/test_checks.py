from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.measurements.views import View
from ipcli.models.fusion import checks
from ipcli.models.fusion.checks import LOOSE, OPENGL, SHIFT_BETTER, convergence_warnings, geometry_warnings, shifted

CAMERA = np.array([[60.0, 0, 39.5], [0, 60, 29.5], [0, 0, 1]])


def look(angle: float, noise: float = 0.01) -> View:
    """A wavy wall 3 away, seen from a circle about it and from a camera off the wall's axis."""
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    world_from_cam = np.eye(4)
    world_from_cam[:3, :3] = turn
    world_from_cam[:3, 3] = [2 - 2.5 * np.sin(angle), 0.4 * angle, 4 - 2.5 * np.cos(angle)]
    rows, columns = np.indices((60, 80))
    rays = np.stack([(columns - 39.5) / 60, (rows - 29.5) / 60, np.ones((60, 80))], -1) @ turn.T
    depth = (7 - world_from_cam[2, 3]) / rays[..., 2]  # of the plane z = 7
    depth += np.random.default_rng(round(1000 * (angle + 1))).normal(0, noise, depth.shape)
    return View(f"{angle:+.2f}", depth.astype(np.float32), CAMERA, np.linalg.inv(world_from_cam))


VIEWS = [look(angle) for angle in (-0.2, -0.1, 0.0, 0.1, 0.2)]


def posed(change) -> list[View]:
    return [replace(view, cam_from_world=change(view.cam_from_world)) for view in VIEWS]


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.2])
def test_sound_views_give_no_warning(noise):
    views = [look(angle, noise) for angle in (-0.2, -0.1, 0.0, 0.1, 0.2)]
    assert geometry_warnings(views, views[2]) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (np.linalg.inv, "in the other direction: see --pose"),
        (lambda pose: OPENGL @ pose, "have OpenGL's axes"),
    ],
)
def test_a_mistake_of_the_poses_is_named(change, words):
    views = posed(change)
    (warning,) = geometry_warnings(views, views[2])
    assert words in warning


@pytest.mark.parametrize("factor", [1000, 1000000])
def test_depth_in_another_unit_than_the_baseline_is_named_with_the_factor(factor):
    views = [replace(view, depth=view.depth * np.float32(factor)) for view in VIEWS]
    (warning,) = geometry_warnings(views, views[2])
    assert f"depth seems to be {factor} times too large" in warning
    assert f"give {factor} times the --depth-scale" in warning


def test_a_view_alone_and_a_camera_that_saw_nothing_are_not_judged():
    assert geometry_warnings(VIEWS[:1], VIEWS[0]) == []
    blind = replace(VIEWS[2], name="camera", depth=np.full_like(VIEWS[2].depth, np.nan))
    assert geometry_warnings(VIEWS, blind) == []


def test_a_gap_far_above_the_tolerance_is_said():
    history = np.array([[0, 50, 1.0, 6.0, np.nan], [0, 100, 1.0, LOOSE * 1e-3, np.nan]])
    assert convergence_warnings(history, 1e-3) == []
    assert convergence_warnings(history[:0], 1e-3) == []
    (warning,) = convergence_warnings(history[:1], 1e-3)
    assert "relative gap is 6 where 0.001" in warning


UNEVEN = [
    look(angle, 0.002) for angle in (-0.25, -0.21, -0.1, 0.0, 0.04, 0.18, 0.22)
]  # a camera that does not move evenly


@pytest.mark.parametrize(("shift", "word"), [(1, "before"), (-1, "after")])
def test_poses_of_the_next_or_the_last_view_are_named(shift, word):
    indices = [k for k in range(len(UNEVEN)) if 0 <= k + shift < len(UNEVEN)]
    views = [replace(UNEVEN[k], cam_from_world=UNEVEN[k + shift].cam_from_world) for k in indices]
    (warning,) = geometry_warnings(views, views[len(views) // 2])
    assert f"if each has the pose of the view {word} it" in warning
    assert "shifted against the images. Look whether the first pose is that of the first image" in warning
    assert geometry_warnings(UNEVEN, UNEVEN[3]) == []


def test_one_view_whose_own_pose_is_off_is_no_shift():
    """With the pose of the view before it, it happens to fit its neighbours better; they do not fit theirs better."""
    off = UNEVEN[2].cam_from_world
    views = [*UNEVEN[:3], replace(UNEVEN[3], cam_from_world=off), *UNEVEN[4:]]
    (then, now, word), *_ = [one for one in shifted(views, views[3]) if one[0] * SHIFT_BETTER < one[1]]
    assert then < now
    assert geometry_warnings(views, views[3]) == []


def at_size(view: View, factor: float, shift: tuple[float, float] = (0, 0)) -> View:
    camera = np.diag([factor, factor, 1.0]) @ view.intrinsics
    camera[:2, 2] += shift
    return replace(view, intrinsics=camera)


@pytest.mark.parametrize(
    ("factor", "shift", "words"),
    [
        (2.0, (0, 0), "calibration seems to be of images 2 times as large: divide --intrinsics by that"),
        (0.5, (0, 0), "calibration seems to be of images 0.5 times as large"),
        (1.0, (25, 0), "lies at 81% of the width and 50% of the height: unless the images are crops"),
    ],
)
def test_a_principal_point_far_from_the_middle_is_named(factor, shift, words):
    views = [at_size(view, factor, shift) for view in VIEWS]
    assert any(words in warning for warning in geometry_warnings(views, views[2]))


def test_a_principal_point_near_the_middle_is_none_of_our_business():
    views = [at_size(view, 1.0, (8, -6)) for view in VIEWS]
    assert geometry_warnings(views, views[2]) == []


def test_large_views_are_looked_at_by_some_rows_and_columns_and_say_the_same(monkeypatch):
    views = posed(np.linalg.inv)
    monkeypatch.setattr(checks, "PIXELS", 1500)
    assert checks.thinned(views[0]).depth.shape == (30, 40)
    (warning,) = geometry_warnings(views, views[2])
    assert "in the other direction: see --pose" in warning
    assert geometry_warnings(VIEWS, VIEWS[2]) == []
