"""Moving pictures of reliefs: light from the side it comes from, what is nearer hides what is farther."""

import numpy as np

from ipcli.report.brdf import relief


def hemisphere(side=60):
    axis = (np.arange(side) + 0.5) / side * 2.2 - 1.1
    x, y = np.meshgrid(axis, -axis)
    z = np.sqrt(np.where(x * x + y * y < 1, 1 - x * x - y * y, np.nan))
    return z * side / 2.2, np.stack([x, y, z], axis=-1)


def test_the_lamp_lights_its_own_side():
    _, normals = hemisphere()
    left = relief.lit(normals, np.array([-0.8, 0, 0.6])).astype(int).sum(axis=-1)
    assert left[30, 12] > left[30, 48] + 100
    above = relief.lit(normals, np.array([0, 0.8, 0.6])).astype(int).sum(axis=-1)
    assert above[12, 30] > above[48, 30] + 100


def test_a_turned_relief_shows_the_nearer_surface():
    height, normals = hemisphere()
    height[28:32, 28:32] += 20
    colours = np.zeros((*height.shape, 3), np.uint8)
    colours[28:32, 28:32] = [255, 0, 0]
    front = relief.seen(height, normals, 0.0, colours, pitch=0.0)
    assert (front[..., 0] == 255).sum() >= 16
    away = relief.seen(height, normals, 60.0, colours, pitch=0.0)
    red = np.nonzero(away[..., 0] == 255)[1].mean()
    assert red > away.shape[1] / 2 + 10  # what stands out to the viewer goes right when the left is turned to the front


def test_films_are_frames_of_one_size_and_need_no_script():
    height, normals = hemisphere()
    frames = relief.swinging(height, normals)
    assert len({frame.shape for frame in frames}) == 1
    text = relief.film(frames, "Turned") + relief.style()
    assert "<script" not in text
    assert "steps(" in text


def test_normals_as_colours_are_half_plus_half():
    _, normals = hemisphere()
    np.testing.assert_allclose(relief.as_colours(normals)[30, 30], 127.5 * (normals[30, 30] + 1), atol=0.5)
