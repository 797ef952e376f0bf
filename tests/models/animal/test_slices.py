"""An ellipsoid seen from the left and from beside it: where it lies along the first view, and how thick it is."""

import numpy as np
import pytest

from ipcli.geometry.orthographic import Orthographic, of_view
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.slices import AS_LIFTED, Slices, fitted

AXES, MIDDLE = np.array([1.0, 0.3, 0.4]), np.array([0.1, 0.2, 0.0])
LEFT, OBLIQUE = (Orthographic(of_view(view), 100.0, np.array([130.0, 60.0])) for view in ("left", "40,15"))
SHAPE = (120, 260)


def inside(camera):
    """1 - r^2 (h, w) of each pixel, where r is 1 at the rim of the ellipsoid's outline."""
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    at = np.stack([columns, rows], axis=-1) - camera.project(MIDDLE)
    spread = camera.rotation[:2] @ np.diag(AXES**2) @ camera.rotation[:2].T * camera.scale**2
    return 1 - np.einsum("hwa,ab,hwb->hw", at, np.linalg.inv(spread), at)


HEIGHTS = AXES[1] * LEFT.scale * np.sqrt(np.maximum(inside(LEFT), 0.0))
SEEN = PartImage("oblique", (inside(OBLIQUE) > 0).astype(np.int16), "40,15")


def cut(heights=HEIGHTS, image=SEEN):
    return Slices.of(heights, LEFT, 0, image, OBLIQUE, 0.02)


@pytest.mark.parametrize("flat", [1.0, 0.6])
def test_the_ends_tell_depth_and_thickness(flat):
    slices = cut(flat * HEIGHTS)
    assert slices.lean == pytest.approx(np.sin(np.arccos(np.sin(np.radians(40)) * np.cos(np.radians(15)))))
    assert fitted(slices.ratios()) == pytest.approx(1 / flat, rel=0.1)
    assert slices.depths(1 / flat) == pytest.approx(LEFT.depth(MIDDLE), abs=0.03)


def test_an_end_at_another_part_is_no_contour_and_tells_nothing():
    labels = SEEN.labels.copy()
    columns = np.flatnonzero(labels.any(axis=0))
    labels[:, columns[-len(columns) // 3 :]] *= 2
    slices = cut(image=PartImage("oblique", labels, "40,15"))
    hidden = slices.is_contour.sum(axis=0) == 1
    assert hidden.sum() > 20
    assert slices.depths(1.0) == pytest.approx(LEFT.depth(MIDDLE), abs=0.03)


def test_few_slices_hardly_change_the_aspect():
    assert fitted([]) == 1.0
    assert fitted([2.5] * (AS_LIFTED - 1)) == 1.0
    assert fitted([1.5] * (AS_LIFTED + 1)) == 1.5


def test_a_part_that_both_show_in_different_slices_has_no_depth():
    labels = np.zeros(SHAPE, np.int16)
    labels[-8:, :20] = 1
    assert cut(image=PartImage("elsewhere", labels, "40,15")).depths(1.0) is None


def test_slices_are_numbered_along_the_axis():
    slices = cut()
    assert slices.number(np.array([(slices.first + 3) * slices.width, -99.0])).tolist() == [3, 0]
