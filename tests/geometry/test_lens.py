"""Lenses: there and back, agreement with OpenCV and pycolmap."""

import cv2
import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.geometry import lens

LENSES = {
    "pinhole": np.zeros(0),
    "radtan": np.array([-0.28, 0.07, 0.0002, -0.0001]),
    "equidistant": np.array([0.03, -0.02, 0.004, -0.001]),
    "fisheye624": np.array([0.03, -0.03, 0.04, -0.05, 0.016, -0.0008, 0.0002, 0.0006, 0.0007, -1e-6, -0.0009, -5e-5]),
}


def grid(most):
    x, y = np.meshgrid(np.linspace(-most, most, 9), np.linspace(-most, most, 7))
    return np.stack([x, y], axis=-1)


@pytest.mark.parametrize("model", LENSES)
def test_undistort_undoes_distort(model):
    points = grid(0.7)
    assert np.allclose(
        lens.undistort(model, LENSES[model], lens.distort(model, LENSES[model], points)), points, atol=1e-9
    )


@pytest.mark.parametrize("count", [4, 5, 8])
def test_radtan_is_opencvs(count):
    k = np.array([-0.28, 0.07, 0.0002, -0.0001, 0.01, 0.02, -0.01, 0.003])[:count]
    points = grid(0.7).reshape(-1, 2)
    rays = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    expected, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), np.eye(3), k)
    assert np.allclose(lens.distort("radtan", k, points), expected[:, 0], atol=1e-12)


def test_equidistant_is_opencvs_fisheye():
    points = grid(1.2).reshape(-1, 1, 2)
    expected = cv2.fisheye.distortPoints(points, np.eye(3), LENSES["equidistant"])
    assert np.allclose(lens.distort("equidistant", LENSES["equidistant"], points), expected, atol=1e-12)


def test_fisheye624_is_colmaps_thin_prism_fisheye():
    pycolmap = pytest.importorskip("pycolmap")
    camera = pycolmap.Camera(
        model="RAD_TAN_THIN_PRISM_FISHEYE", width=512, height=512, params=[1, 1, 0, 0, *LENSES["fisheye624"]]
    )
    points = grid(1.0).reshape(-1, 2)
    expected = np.array([camera.img_from_cam(np.append(point, 1.0)) for point in points])
    assert np.allclose(lens.distort("fisheye624", LENSES["fisheye624"], points), expected, atol=1e-9)


def test_what_no_direction_is_drawn_at_is_nan():
    barrel = np.array([-0.28, 0.0, 0.0, 0.0])  # draws nothing farther out than the ray at r = 1.09, and none twice
    far = np.array([[0.8, 0.0], [5.0, 5.0]])
    assert np.isnan(lens.undistort("radtan", barrel, far)).all()
    assert np.allclose(lens.undistort("radtan", barrel, np.array([[0.6, 0.0]])), [[0.6933, 0.0]], atol=1e-3)


def test_unknown_models_are_refused():
    with pytest.raises(ParameterError, match="lens model 'mirror'"):
        lens.distort("mirror", np.zeros(0), np.zeros((1, 2)))
