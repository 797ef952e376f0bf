"""Figures of errors summed up, by their definitions."""

import numpy as np
import pytest

from ipcli.measurements.accuracy import depth_average, mean_over_scenes, sparsification_curve, thinned_camera, thinning


def test_errors_have_a_geometric_mean_and_percentages_an_arithmetic_one():
    values = np.array([[[1.0, 0.0]], [[4.0, 3.0]]])
    np.testing.assert_allclose(mean_over_scenes(values, ["RMSE", "out-3 %"]), [[2.0, 1.5]])


def test_what_is_not_known_of_one_scene_is_not_known_of_the_mean():
    assert np.isnan(mean_over_scenes(np.array([[1.0], [np.nan]]), ["RMSE"]))[0]


def test_the_depth_average_is_that_of_the_thesis_tables():
    """L1-heuristic of table 4.2: RMSE, ZMAE and NMAE give its Z-avg."""
    row = np.array([9.0, 0.0831, 0.0572, 0.5893])
    assert depth_average(row, ["RMSE", "centred RMSE", "Z-MAE", "N-MAE rad"]) == pytest.approx(0.1410, abs=1e-4)


def test_sparsification_against_its_definition():
    rng = np.random.default_rng(2)
    error, confidence = rng.gamma(1, 1, 500), rng.gamma(1, 1, 500)
    shares, kept = sparsification_curve(error, -confidence)
    for share, mean in zip(shares, kept, strict=True):
        count = round(share * 5)
        assert mean == pytest.approx(error[np.argsort(-confidence)[:count]].mean())
    assert shares[-1] == 100
    assert kept[-1] == pytest.approx(error.mean())
    assert (sparsification_curve(error, error)[1] <= kept + 1e-12).all()


def test_maps_are_thinned_only_beyond_the_most_pixels_and_the_camera_with_them():
    assert thinning(4_000_000) == 1
    assert thinning(20_000_000) == 3
    assert 20_000_000 / thinning(20_000_000, 1_000_000) ** 2 <= 1_000_000
    camera = np.array([[60.0, 0, 22.5], [0, 58.0, 17.5], [0, 0, 1]])
    point = np.array([0.3, 0.1, 2.0])
    np.testing.assert_allclose((thinned_camera(camera, 3) @ point)[:2], (camera @ point)[:2] / 3)
