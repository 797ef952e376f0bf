from __future__ import annotations

import numpy as np
import pytest

from ipcli.geometry.stereo import consistent, semi_global

WIDTH, HEIGHT = 240, 60
BACK, FRONT = 8, 24  # disparities of a wall and of a board in front of it
BOARD = (slice(15, 45), slice(100, 160))  # in the left image


@pytest.fixture(scope="module")
def pair() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Left and right image of a textured board in front of a textured wall, and the disparity of the left one."""
    rng = np.random.default_rng(5)
    wall = rng.integers(0, 256, (HEIGHT, WIDTH + BACK), dtype=np.uint8)
    left, right = wall[:, :WIDTH].copy(), wall[:, BACK : BACK + WIDTH].copy()
    board = rng.integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)[BOARD]
    left[BOARD] = board
    right[BOARD[0], BOARD[1].start - FRONT : BOARD[1].stop - FRONT] = board
    truth = np.full((HEIGHT, WIDTH), float(BACK))
    truth[BOARD] = FRONT
    return left, right, truth


def seen_by_both(truth: np.ndarray) -> np.ndarray:
    columns = np.arange(WIDTH)
    hidden = np.zeros_like(truth, dtype=bool)
    hidden[BOARD[0]] = (columns >= BOARD[1].start - (FRONT - BACK)) & (columns < BOARD[1].start)
    return ~hidden & (columns >= BACK)


def test_both_cameras_see_wall_and_board_where_they_are(pair):
    left, right, truth = pair
    of_left, of_right = semi_global(left, right, disparities=64)
    known = np.isfinite(of_left) & seen_by_both(truth)
    assert known.sum() > 0.9 * seen_by_both(truth).sum()
    assert np.mean(np.abs(of_left[known] - truth[known]) < 0.5) > 0.97
    inner = (slice(20, 40), slice(BOARD[1].start - FRONT + 5, BOARD[1].stop - FRONT - 5))
    assert np.nanmedian(of_right[inner]) == pytest.approx(FRONT, abs=0.1)
    assert np.nanmedian(of_right[:, 200:225]) == pytest.approx(BACK, abs=0.1)


def test_the_left_margin_of_the_search_length_is_matched_too(pair):
    left, right, _ = pair
    of_left, _ = semi_global(left, right, disparities=64)
    assert np.mean(np.isfinite(of_left[:, BACK + 2 : 64])) > 0.85


def test_consistency_removes_what_only_one_camera_sees(pair):
    left, right, truth = pair
    loose, _ = semi_global(left, right, disparities=64)
    strict, _ = semi_global(left, right, disparities=64, consistency=1.0)
    hidden = ~seen_by_both(truth)
    assert np.isfinite(strict[hidden]).mean() < 0.3
    assert np.array_equal(strict[np.isfinite(strict)], loose[np.isfinite(strict)])


def test_the_right_camera_is_the_left_one_in_a_mirror(pair):
    left, right, _ = pair
    _, of_right = semi_global(left, right, disparities=64, consistency=1.0)
    mirrored, _ = semi_global(right[:, ::-1], left[:, ::-1], disparities=64, consistency=1.0)
    np.testing.assert_array_equal(of_right, mirrored[:, ::-1])


def test_consistency_agrees_with_its_definition_pixel_by_pixel():
    rng = np.random.default_rng(2)
    of_left, of_right = rng.uniform(0.5, 6, (2, 5, 12)).astype(np.float32)
    of_left[2, 7] = of_right[3, 4] = np.nan
    kept = consistent(of_left, of_right, 1.5)
    for row, column in np.ndindex(of_left.shape):
        disparity = of_left[row, column]
        match = 0 if np.isnan(disparity) else min(max(round(float(column - disparity)), 0), 11)
        expected = disparity if abs(disparity - of_right[row, match]) <= 1.5 else np.nan
        np.testing.assert_equal(kept[row, column], expected)
