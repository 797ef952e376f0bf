from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli.measurements.views import View
from ipcli.models.fusion.checks import LOOSE, OPENGL, convergence_warnings, geometry_warnings

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
