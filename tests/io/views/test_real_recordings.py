"""Real data: the depth of one frame, carried into the next by our conventions, meets the depth measured there."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, project, transform
from ipcli.io.views import layouts
from ipcli.measurements.views import View, relative

pytestmark = pytest.mark.real


def residual(src: View, dst: View) -> np.ndarray:
    """Depth in the frame of ``dst`` of the points of ``src``, minus the depth measured at the nearest pixel there."""
    points = transform(relative(dst, src), back_project(src.depth, src.intrinsics)).reshape(-1, 3)
    pixels = np.rint(project(points, dst.intrinsics))
    height, width = dst.depth.shape
    inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
    u, v = pixels[inside].astype(int).T
    difference = points[inside, 2] - dst.depth[v, u]
    return difference[np.isfinite(difference)]


def spread(values: np.ndarray) -> float:
    return float(np.median(np.abs(values - np.median(values))))


@pytest.mark.parametrize(("apart", "bound"), [(1, 0.002), (10, 0.006)])
def test_living_room_frames_agree(real_data, apart, bound):
    sequence = layouts.open_views(real_data("fusion/livingroom1_clean_micro"))
    first, second = (sequence.load(sequence.names[20 + step]) for step in (0, apart))
    difference = residual(first, second)
    assert len(sequence.names) == 80
    assert len(difference) > 0.5 * first.depth.size
    assert spread(difference) < bound
    assert abs(np.median(difference)) < bound


def test_living_room_disagrees_as_soon_as_a_convention_is_wrong(real_data):
    from dataclasses import replace

    sequence = layouts.open_views(real_data("fusion/livingroom1_clean_micro"))
    first, second = (sequence.load(sequence.names[index]) for index in (20, 30))
    wrong = [replace(view, cam_from_world=np.linalg.inv(view.cam_from_world)) for view in (first, second)]
    assert spread(residual(*wrong)) > 5 * spread(residual(first, second))


def test_kinect_frames_of_the_kitchen_agree_and_have_gaps(real_data):
    sequence = layouts.open_views(real_data("fusion/sevenscenes_kitchen"))
    first, second = (sequence.load(name) for name in sequence.names[:2])
    assert first.image.shape == (480, 640, 3)
    assert 0.02 < np.isnan(first.depth).mean() < 0.3
    assert np.nanmax(first.depth) < 10
    assert spread(residual(first, second)) < 0.012
