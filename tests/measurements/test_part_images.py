"""Part images: trees in order, and what is odd about masks."""

import numpy as np

from ipcli.measurements.part_images import PartImage, PartTree, folded, oddities, told
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
    found = " | ".join(told(oddities([PartImage("a", labels)], tree)))
    for words in ("hole", "touches the border", "leg in a: only 18 pixels", "2 blobs", "tail: no image"):
        assert words in found


def test_much_of_an_animal_that_is_left_out_is_told_of():
    labels = np.zeros((40, 40), np.int16)
    labels[5:25, 5:25] = 1
    tree = PartTree(("torso",), (-1,))
    (found,) = folded(oddities([PartImage("a", labels, dropped={"rest": 90, "eye": 4})], tree))
    assert found == "rest in a: 90 pixels of the animal are left out, so that the model has a gap there"


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


def test_alike_ones_are_one_line_and_harmless_ones_none():
    labels = np.zeros((40, 60), np.int16)
    labels[5:20, 5:50] = 1
    labels[25:30, 5:10] = labels[25:30, 15:20] = 2  # in two blobs of 25 pixels
    labels[25:28, 30:33] = 3
    labels[8, 8] = 0  # a hole of one pixel
    whole = np.where(labels == 2, 0, labels)
    whole[22:38, 5:12] = 2  # in one piece
    tree = PartTree(("torso", "leg", "ear"), (-1, 0, 0))
    alone = folded(oddities([PartImage("a", labels)], tree))
    assert alone[0] == "2 masks: too few pixels to tell a shape: leg in a, ear in a"
    assert [line for line in alone if "blobs" in line] == ["leg in a: 2 blobs; only the largest gives shape"]
    assert not any("hole" in line for line in alone)
    both = oddities([PartImage("a", labels), PartImage("b", whole)], tree)
    assert folded(both) == ["2 masks: too few pixels to tell a shape: ear in a, ear in b"]
    assert "leg in a: 2 blobs; only the largest gives shape" in told(both)
