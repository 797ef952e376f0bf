"""A model is doubtful where it is unlike its images, lacks parts, or hangs on an angle that nothing tells."""

import numpy as np

from ipcli.geometry.orthographic import Orthographic, of_view
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.doubts import beforehand, doubts

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
    (words,) = said(("left", "front"), bent=0.579)
    assert "covers only 58 %" in words
    assert "--other-pose ignore" in words
    assert not said(("left", "front"), bent=0.7)


def test_two_lines_of_view_do_not_tell_their_angle():
    (words,) = said(("left", "40,15"), given=("left",))
    assert words.startswith("40,15: two lines")
    assert said(("left", "right", "40,15"), given=("left", "right"))
    assert not said(("left", "40,15"))
    assert not said(("left", "front", "40,15"), given=("left", "front"))
    assert not said(("left", "front", "40,15"), given=("left",))


def images_from(views):
    return [PartImage(f"image {k}", np.ones((2, 2), np.int16), view) for k, view in enumerate(views)]


def test_views_along_one_line_do_not_tell_the_depth():
    for views in (("left", "right"), ("left", "left"), ("left", "88,0"), ("45,0", "225,0"), ("45,30", "60,30")):
        (words,) = beforehand(images_from(views))
        assert words.startswith("image 0, image 1: all views look along one line")
    for views in (("left",), ("45,0",), (None,)):
        assert beforehand(images_from(views))[0].startswith("one view alone")
    for views in (("left", "front"), ("left", "135,0"), ("left", None), (None, None)):
        assert beforehand(images_from(views)) == []


def test_a_camera_that_is_found_along_the_line_of_the_others_does_not_tell_the_depth():
    (words,) = said(("left", "right", "88,2"), given=("left", "right"))
    assert words.startswith("88,2: all views look along one line")
