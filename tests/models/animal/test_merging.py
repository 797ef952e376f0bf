"""Merging: which aspects are paired, and that the mean does not depend on their order."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.measurements.part_images import PartImage, PartMatches
from ipcli.models.animal import merging
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import Inflation, Registration

LABELS = np.ones((4, 4), np.int16)


def image(name, view, is_reference=True):
    return PartImage(name, LABELS, view, is_reference)


def pairs(images, matches=(), other_pose="bend"):
    return [(one, two) for _, one, two in merging.alike(images, [(i.name, 0) for i in images], matches, other_pose)]


def test_same_sides_are_paired_and_nothing_else():
    left, again, front = image("left", "left"), image("again", "left"), image("front", "front")
    other, above = image("other", "left", False), image("above", "top", False)
    assert pairs([left, front, image("beside", None)]) == []
    assert pairs([left, front, again]) == [("left", "again")]
    assert pairs([left, front, other]) == [("left", "other")]
    assert pairs([left, front, other], other_pose="ignore") == []
    assert pairs([left, front, other, above]) == []  # these two give a model of their own
    match = PartMatches(0, ("beside", "left"), np.zeros((4, 2, 2)))
    assert pairs([left, front, image("beside", None)], [match]) == [("left", "beside")]


@pytest.fixture(scope="module")
def limb():
    rows, columns = np.mgrid[:24, :44]
    mask = (np.abs(rows - 11) < 7 - 0.1 * columns) & (columns > 3) & (columns < 40)
    return inflate(mask, Inflation(triangles=80))


def test_each_takes_the_mean_and_neither_order_nor_reference_matters(limb):
    factors = {"a": 1.0, "b": 1.3, "c": 0.9}
    aspects = {
        (name, 0): replace(limb, heights=f * limb.heights, picture=np.float32(f) * limb.picture)
        for name, f in factors.items()
    } | {("a", 1): limb}
    pairs = [(0, "a", "b"), (0, "a", "c"), (0, "b", "c")]
    found, overlays = merging.merged(aspects, pairs, (), Registration())
    turned, _ = merging.merged(aspects, [(part, two, one) for part, one, two in pairs[::-1]], (), Registration())
    assert found["a", 1] is limb
    assert [o.is_used for o in overlays] == [True] * 3
    high = limb.picture > 3
    for key in (("a", 0), ("b", 0), ("c", 0)):
        assert np.abs(found[key].picture - turned[key].picture).max() < 0.02 * limb.picture.max()
        ratio = np.median(found[key].picture[high] / limb.picture[high])
        assert ratio == pytest.approx(np.mean([1.0, 1.3, 0.9]), rel=0.06)  # similarities take some of it as a scale


def test_what_is_not_alike_is_left_alone(limb):
    rows, columns = np.mgrid[:60, :60]
    ring = (np.abs(np.hypot(rows - 30, columns - 30) - 20) < 5) & (columns > 12)
    aspects = {("a", 0): limb, ("b", 0): inflate(ring, Inflation(triangles=200))}
    found, overlays = merging.merged(aspects, [(0, "a", "b")], (), Registration())
    assert not overlays[0].is_used
    assert all(found[key] is aspects[key] for key in aspects)
