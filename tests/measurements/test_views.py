"""Views, their relative motions, and the check that unsound ones do not pass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import FormatError
from ipcli.geometry.cameras import transform
from ipcli.measurements.views import View, check_view, relative

INTRINSICS = np.array([[310.0, 0.4, 20.3], [0.0, 290.0, 14.6], [0.0, 0.0, 1.0]])


def rotation(rng: np.random.Generator) -> np.ndarray:
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return matrix * np.sign(np.linalg.det(matrix))


def pose(rng: np.random.Generator) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation(rng), rng.normal(size=3)
    return matrix


def view(**changes) -> View:
    rng = np.random.default_rng(3)
    depth = rng.uniform(1, 5, (4, 6)).astype(np.float32)
    depth[1, 2] = np.nan
    return replace(View("left", depth, INTRINSICS, pose(rng)), **changes)


@given(st.integers(0, 2**32 - 1))
def test_relative_motion_moves_points_from_one_camera_frame_to_the_other(seed):
    rng = np.random.default_rng(seed)
    here, there = view(cam_from_world=pose(rng)), view(cam_from_world=pose(rng))
    world = rng.normal(size=(5, 3))
    moved = transform(relative(there, here), transform(here.cam_from_world, world))
    np.testing.assert_allclose(moved, transform(there.cam_from_world, world), atol=1e-9)


def test_sound_views_pass_the_check():
    seen = view()
    companions = {
        "confidence": np.ones((4, 6), np.float32),
        "image": np.zeros((4, 6, 3), np.uint8),
        "truth": seen.depth,
    }
    full = replace(seen, **companions)
    assert check_view(full) is full


def changed(array: np.ndarray, index, value) -> np.ndarray:
    array = np.array(array)
    array[index] = value
    return array


SOUND = view()
MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])
SCALED = np.diag([1.01, 1.01, 1.01, 1.0])
BAD = {
    "depth of 3 dimensions": (
        dict(depth=np.ones((2, 2, 1), np.float32)),
        r"depth is not an image \(expected shape \(h, w\), got \(2, 2, 1\)\)",
    ),
    "empty depth": (dict(depth=np.ones((0, 2), np.float32)), "depth is not an image"),
    "zero depth": (
        dict(depth=changed(SOUND.depth, (2, 3), 0)),
        r"1 depth values are not positive.*0\.0 at row 2, column 3.*NaN",
    ),
    "negative depth": (dict(depth=changed(SOUND.depth, 0, -1)), "6 depth values.*row 0, column 0"),
    "infinite depth": (dict(depth=changed(SOUND.depth, (3, 5), np.inf)), "inf at row 3, column 5"),
    "confidence of another size": (
        dict(confidence=np.ones((4, 5))),
        r"confidence does not cover.*expected \(4, 6\), got \(4, 5\)",
    ),
    "negative confidence": (dict(confidence=np.full((4, 6), -1.0)), "confidence is not a finite number"),
    "NaN confidence": (dict(confidence=np.full((4, 6), np.nan)), "confidence is not a finite number"),
    "image of another size": (
        dict(image=np.zeros((8, 12, 3), np.uint8)),
        r"image does not cover.*\(4, 6, 3\), got \(8, 12, 3\)",
    ),
    "gray image": (dict(image=np.zeros((4, 6), np.uint8)), "image does not cover"),
    "truth of another size": (dict(truth=np.ones((6, 4))), "truth does not cover"),
    "infinite truth": (dict(truth=np.full((4, 6), np.inf)), "24 truth values"),
    "3x4 intrinsics": (
        dict(intrinsics=np.ones((3, 4))),
        r"intrinsics have the wrong shape \(expected \(3, 3\), got \(3, 4\)\)",
    ),
    "transposed intrinsics": (dict(intrinsics=INTRINSICS.T), "not a camera matrix.*transposed"),
    "scaled last row": (dict(intrinsics=2 * INTRINSICS), "not a camera matrix"),
    "NaN intrinsics": (dict(intrinsics=changed(INTRINSICS, (0, 2), np.nan)), "not a camera matrix"),
    "negative focal length": (
        dict(intrinsics=INTRINSICS @ np.diag([1, -1, 1])),
        r"focal length.*got \(310\.0, -290\.0\)",
    ),
    "3x4 pose": (dict(cam_from_world=np.eye(4)[:3]), r"pose has the wrong shape.*last row 0 0 0 1"),
    "NaN pose": (dict(cam_from_world=changed(np.eye(4), (1, 3), np.nan)), "pose holds NaN"),
    "transposed pose": (dict(cam_from_world=SOUND.cam_from_world.T), "wrong last row"),
    "scaled pose": (dict(cam_from_world=SCALED), r"not rigid \(expected .* <= 0\.001, got 0\.0201\)"),
    "mirrored pose": (dict(cam_from_world=MIRROR), "pose mirrors the scene"),
}


@pytest.mark.parametrize(("change", "message"), BAD.values(), ids=BAD)
def test_unsound_views_are_refused_by_name_with_what_was_expected(change, message):
    with pytest.raises(FormatError, match=message) as refusal:
        check_view(view(**change), "poses.txt")
    assert str(refusal.value).startswith("poses.txt: view 'left': ")
    assert "\n" not in str(refusal.value)
