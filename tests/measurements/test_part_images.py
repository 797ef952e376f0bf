"""Part images: trees in order, and what is odd about masks."""

import numpy as np

from ipcli.measurements.part_images import PartImage, PartTree, oddities
from tests.fixtures import limbs


def test_parents_come_before_their_children():
    tree = PartTree(("head", "neck", "torso"), (1, 2, -1))
    assert tree.root == 2
    assert tree.downwards() == [2, 1, 0]


def test_odd_masks_are_told_of():
    labels = np.zeros((40, 40), np.int16)
    labels[0:20, 5:30] = 1
    labels[8:12, 10:14] = 0
    labels[30:33, 5:8] = labels[30:33, 20:23] = 2
    tree = PartTree(("torso", "leg", "tail"), (-1, 0, 0))
    found = " | ".join(oddities([PartImage("a", labels)], tree))
    for words in ("hole", "touches the border", "leg in a: only 18 pixels", "2 blobs", "tail: no image"):
        assert words in found


def test_sound_masks_are_not():
    assert oddities([shot for shot, _ in limbs.shots(("left", "right"))], limbs.TREE) == []


def test_outlines_are_what_lies_beside_the_background():
    labels = np.zeros((6, 7), np.int16)
    labels[1:5, 1:4], labels[1:5, 4:6] = 1, 2
    labels[2, 2] = 3  # in the midst of the first
    found = PartImage("a", labels).outlines()
    assert set(found) == {0, 1}
    inner = {(2, 2), (2, 3), (3, 2), (3, 3), (4, 2), (4, 3)}  # as (column, row)
    assert {tuple(pixel) for pixel in found[0]} == {(c, r) for c in (1, 2, 3) for r in range(1, 5)} - inner
    assert {tuple(pixel) for pixel in found[1]} == {(c, r) for c in (4, 5) for r in range(1, 5)} - inner
