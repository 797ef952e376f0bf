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
    rows, columns = np.mgrid[:36, :64]
    mask = (np.abs(rows - 17) < 8 - 0.08 * columns) & (columns > 5) & (columns < 58)
    return inflate(mask, Inflation(triangles=150))


def test_each_takes_the_mean_and_the_order_does_not_matter(limb):
    thicker = replace(limb, heights=1.3 * limb.heights, picture=np.float32(1.3) * limb.picture)
    aspects = {("a", 0): limb, ("b", 0): thicker, ("a", 1): limb}
    params = Registration()
    found, overlays = merging.merged(aspects, [(0, "a", "b")], (), params)
    turned, _ = merging.merged(aspects, [(0, "b", "a")], (), params)
    assert found["a", 1] is limb
    assert [o.is_used for o in overlays] == [True]
    high = limb.picture > 4
    for key in (("a", 0), ("b", 0)):
        assert np.abs(found[key].picture - turned[key].picture).max() < 0.15
        ratio = found[key].picture[high] / limb.picture[high]
        assert 1.08 < np.median(ratio) < 1.22


def test_what_is_not_alike_is_left_alone(limb):
    rows, columns = np.mgrid[:60, :60]
    ring = (np.abs(np.hypot(rows - 30, columns - 30) - 20) < 5) & (columns > 12)
    aspects = {("a", 0): limb, ("b", 0): inflate(ring, Inflation(triangles=200))}
    found, overlays = merging.merged(aspects, [(0, "a", "b")], (), Registration())
    assert not overlays[0].is_used
    assert all(found[key] is aspects[key] for key in aspects)
