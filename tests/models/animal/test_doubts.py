"""A model is doubtful where it is unlike its images, lacks parts, or hangs on an angle that nothing tells."""

import numpy as np

from ipcli.geometry.orthographic import Orthographic, of_view
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.doubts import doubts

TREE = PartTree(("torso", "head"), (-1, 0), (1.0, 1.0))
BOTH = np.array([0, 1])


def said(views, overlaps=(0.9, 0.9, 0.9), face_part=BOTH, given=None, bent=None):
    """Doubts of images from these views, of which only those in `given` are known."""
    given = views if given is None else given
    masks = np.ones((2, 2), np.int16)
    images = [PartImage(view, masks, view if view in given else None) for view in views]
    cameras = [Orthographic(of_view(view), 1.0, np.zeros(2)) for view in views]
    return doubts(images, cameras, TREE, overlaps[: len(views)], face_part, bent)


def test_a_good_model_is_not_doubted():
    assert said(("left", "front")) == []


def test_an_image_that_the_model_is_unlike_is_named():
    (words,) = said(("left", "front"), overlaps=(0.9, 0.46))
    assert words.startswith("front: the model shows the right part in only 46 %")


def test_a_lost_part_is_named():
    (words,) = said(("left", "front"), face_part=np.array([0]))
    assert words.startswith("not in the model: head.")


def test_an_animal_of_the_other_pose_that_does_not_fit_is_told():
    (words,) = said(("left", "front"), bent=0.734)
    assert "covers only 73 %" in words
    assert "--other-pose ignore" in words
    assert not said(("left", "front"), bent=0.8)


def test_two_lines_of_view_do_not_tell_their_angle():
    (words,) = said(("left", "40,15"), given=("left",))
    assert words.startswith("40,15: two lines")
    assert said(("left", "right", "40,15"), given=("left", "right"))
    assert not said(("left", "40,15"))
    assert not said(("left", "front", "40,15"), given=("left", "front"))
    assert not said(("left", "front", "40,15"), given=("left",))
