"""Error figures by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.models.fusion.metrics import (
    ause,
    compare,
    depth_errors,
    disparity_errors,
    normal_error,
)
from tests.fixtures.fusion_scenes import camera


def test_depth_errors_of_four_pixels_by_hand():
    truth = np.full((2, 3), 2.0)
    depth = truth + [[1, -1, 3], [1, 99, np.nan]]
    where = np.array([[True, True, True], [True, False, False]])
    rmse, mae, centred, z_mae = depth_errors(depth, truth, where)
    assert rmse == pytest.approx(np.sqrt(12 / 4))
    assert mae == pytest.approx(6 / 4)
    assert centred == pytest.approx(np.sqrt((0 + 4 + 4 + 0) / 4))  # about the mean error 1
    assert z_mae == pytest.approx((0 + 2 + 2 + 0) / 4)  # about the median error 1
    assert np.isnan(depth_errors(depth, truth, where & False)).all()


def test_normal_errors_are_angles_and_a_missing_normal_counts_a_right_one():
    true_n = np.tile([0.0, 0, -1], (1, 4, 1))
    n = np.array([[[0, 0, -1], [0, np.sin(0.3), -np.cos(0.3)], [np.nan] * 3, [1, 0, 0]]])
    true_n[0, 3] = np.nan
    everywhere = np.ones((1, 4), bool)
    assert normal_error(n, true_n, everywhere) == pytest.approx((0 + 0.3 + np.pi / 2) / 3)
    assert np.isnan(normal_error(n, true_n, ~everywhere))


def test_disparity_errors_count_what_is_off_by_more_than_three_pixels():
    truth = np.array([[10.0, 10, 10, 10, np.nan]])
    disparity = np.array([[10.0, 13, 13.5, 13.5, 20]])
    assert disparity_errors(disparity, truth) == pytest.approx([50.0, (0 + 3 + 3.5 + 3.5) / 4])


def test_maps_are_compared_where_all_have_a_value_but_their_density_is_their_own():
    truth = np.full((5, 6), 2.0, np.float32)
    dense, sparse = truth + np.float32(0.5), truth.copy()
    dense[4, 5], sparse[:, :3] = 9.0, np.nan
    truth[4, 5] = np.nan
    columns, rows = compare({"dense": dense, "sparse": sparse}, truth, camera((5, 6)), baseline_focal=30.0)
    assert columns[0] == "density %"
    assert columns[-3:] == ["out-3 %", "D-avg px", "out-3 seen %"]
    np.testing.assert_allclose(rows[0, :5], [100, 0.5, 0.5, 0, 0], atol=1e-6)
    np.testing.assert_allclose(rows[1, :5], [100 * 14 / 29, 0, 0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(
        rows[:, -3:], [[0, 3, 0], [0, 0, 0]], atol=1e-5
    )  # 30 / 2 - 30 / 2.5 = 3 is not more than 3
    assert compare({"dense": dense}, truth, camera((5, 6)), None)[1].shape == (1, 6)


def test_disparities_are_counted_with_the_gaps_filled_and_where_all_are_seen():
    truth = np.tile(np.array([3, 3, 3, 3, 1.0], np.float32), (3, 1))  # disparities of 10 and 30
    sparse = truth.copy()
    sparse[:, 3] = np.nan  # filled from the left, the background
    off = truth.copy()
    off[0] = 1.0
    _, rows = compare({"sparse": sparse, "off": off}, truth, camera((3, 5)), baseline_focal=30.0)
    np.testing.assert_allclose(rows[:, -3:], [[0, 0, 0], [100 * 4 / 15, 20 * 4 / 15, 100 * 3 / 12]], atol=1e-5)
    assert np.isnan(
        compare({"sparse": sparse, "none": np.full_like(truth, np.nan)}, truth, camera((3, 5)), 30.0)[1][:, -1]
    ).all()


def test_a_map_with_a_filling_of_its_own_is_judged_by_it():
    truth = np.tile(np.array([3, 3, 3, 3, 1.0], np.float32), (3, 1))  # disparities of 10 and 30
    sparse, own = truth.copy(), truth.copy()
    sparse[:, 3], own[:, 3] = np.nan, 2.0  # a disparity of 15, where the background's is right
    _, rows = compare({"own": sparse, "kit": sparse}, truth, camera((3, 5)), 30.0, None, {"own": own})
    np.testing.assert_allclose(rows[:, -3:], [[20, 1, 0], [0, 0, 0]], atol=1e-5)


def test_the_ause_of_three_pixels_by_hand():
    """Kept in the order given: 3, 2, 4/3; at best 0, 1/2, 4/3. The mean error is 4/3."""
    error, confidence = np.array([-3.0, 1, 0, np.nan]), np.array([9.0, 5, 1, 7])
    assert ause(confidence, error) == pytest.approx((3 + 1.5 + 0) / 3 / (4 / 3))
    assert ause(np.array([1.0, 5, 9, 0]), error) == 0
    assert ause(np.ones(4), error) == pytest.approx((4 / 3 + 4 / 3 - 1 / 2 + 0) / 3 / (4 / 3))  # equal: as at random
    assert np.isnan(ause(confidence, np.full(4, np.nan)))
    assert ause(confidence, np.zeros(4)) == 0


@given(st.integers(0, 2**32 - 1))
def test_no_order_is_better_than_that_of_the_error_nor_worse_than_its_inverse_and_chance_lies_between(seed):
    rng = np.random.default_rng(seed)
    error = rng.exponential(size=400)
    best, worst, even = ause(-error, error), ause(error, error), ause(np.ones(400), error)
    shuffled = np.mean([ause(rng.random(400), error) for _ in range(60)])
    assert best == 0 < ause(rng.random(400), error) < worst
    assert shuffled == pytest.approx(even, rel=0.1)
    assert ause(-(error**2), error) == ause(-error, error)  # the order alone counts
