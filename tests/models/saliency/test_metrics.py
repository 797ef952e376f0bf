"""The measures against their printed formulas, written out once more, and against what must hold."""

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.models.saliency import metrics

RNG = np.random.default_rng(0)
MAP = RNG.random((12, 16)).round(1)  # rounded: ties
POINTS = np.stack([RNG.integers(0, 16, 30), RNG.integers(0, 12, 30)], axis=1)


def roc_area(positives, negatives):
    """The area under the curve of hits over false alarms, threshold by threshold, by the trapezium rule."""
    thresholds = np.unique(np.concatenate([positives, negatives]))[::-1]
    hits = [0.0, *((positives >= t).mean() for t in thresholds)]
    alarms = [0.0, *((negatives >= t).mean() for t in thresholds)]
    return np.trapezoid(hits, alarms)


def test_auc_is_the_area_under_the_curve_with_all_pixels_as_negatives():
    positives = np.array([MAP[y, x] for x, y in POINTS])
    assert metrics.auc(MAP, POINTS).mean() == pytest.approx(roc_area(positives, MAP.ravel()), abs=1e-12)


def test_shuffled_auc_is_the_area_with_fixations_elsewhere_as_negatives():
    elsewhere = np.stack([RNG.integers(0, 16, 50), RNG.integers(0, 12, 50)], axis=1)
    positives, negatives = (np.array([MAP[y, x] for x, y in points]) for points in (POINTS, elsewhere))
    found = metrics.shuffled_auc(MAP, POINTS, elsewhere).mean()
    assert found == pytest.approx(roc_area(positives, negatives), abs=1e-12)


def test_a_prior_that_is_the_same_for_all_pictures_has_a_shuffled_auc_of_exactly_one_half():
    y, x = np.mgrid[0:12, 0:16]
    prior = np.exp(-((x - 7.5) ** 2 / 30 + (y - 5.5) ** 2 / 20))
    sets = [np.stack([RNG.integers(0, 16, 20), RNG.integers(0, 12, 20)], axis=1) for _ in range(5)]
    each = [metrics.shuffled_auc(prior, sets[k], metrics.others(sets, k)) for k in range(5)]
    assert np.concatenate(each).mean() == pytest.approx(0.5, abs=1e-14)


def test_nss_is_the_standardised_map_at_the_fixations_and_nothing_on_a_constant_map():
    values = np.array([MAP[y, x] for x, y in POINTS])
    assert metrics.nss(MAP, POINTS) == pytest.approx((values - np.mean(MAP)) / np.std(MAP))
    assert not metrics.nss(np.full((12, 16), 3.0), POINTS).any()


def test_measures_between_maps_by_their_formulas():
    other = RNG.random((12, 16))
    p, q = other / other.sum(), MAP / MAP.sum()
    assert metrics.correlation(MAP, other) == pytest.approx(np.corrcoef(MAP.ravel(), other.ravel())[0, 1])
    assert metrics.similarity(MAP, other) == pytest.approx(sum(map(min, p.ravel(), q.ravel())))
    eps = 2.2204e-16
    assert metrics.divergence(MAP, other) == pytest.approx(np.sum(p * np.log(eps + p / (q + eps))))
    assert metrics.similarity(other, other) == pytest.approx(1)
    assert metrics.divergence(other, other) == pytest.approx(0, abs=1e-12)
    assert metrics.correlation(np.ones((12, 16)), other) == 0


def test_information_gain_is_in_bits_over_the_baseline():
    uniform, sharp = np.ones((2, 2)), np.array([[1.0, 1.0], [1.0, 5.0]])
    gain = metrics.information_gain(sharp, np.array([[1, 1], [0, 0]]), uniform)
    assert gain == pytest.approx([np.log2(5 / 8 * 4), np.log2(1 / 8 * 4)])


def test_maps_of_counts_are_fixations_and_blurred_maps_are_refused():
    counts = np.zeros((12, 16))
    counts[3, 4], counts[5, 6] = 2, 1
    assert sorted(map(tuple, metrics.fixations_of(counts).tolist())) == [(4, 3), (4, 3), (6, 5)]
    blurred = metrics.fixation_map(np.array([[4, 3]]), (12, 16), 2.0)
    for measure in (metrics.auc, metrics.nss):
        with pytest.raises(ParameterError, match="blurred"):
            measure(MAP, blurred)
    with pytest.raises(ParameterError, match="blurred"):
        metrics.fixations_of((255 * blurred / blurred.max()).astype(np.uint8))


def test_fixations_outside_the_map_are_refused_and_rescaled_ones_stay_inside():
    with pytest.raises(ParameterError, match="outside"):
        metrics.auc(MAP, np.array([[16, 0]]))
    moved = metrics.rescaled(np.array([[-3.0, 5.0], [799.9, 640.0]]), (600, 800), (12, 16))
    assert moved.tolist() == [[0, 0], [15, 11]]


def test_a_fixation_map_is_a_density_around_its_points():
    made = metrics.fixation_map(np.array([[8, 6]]), (12, 16), 1.5)
    assert made.sum() == pytest.approx(1)
    assert np.unravel_index(made.argmax(), made.shape) == (6, 8)
