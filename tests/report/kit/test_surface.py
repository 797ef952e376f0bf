from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ipcli.report.kit import surface

INTRINSICS = np.array([[60.0, 0, 31.5], [0, 60, 23.5], [0, 0, 1]])


def plane(normal: np.ndarray, distance: float) -> np.ndarray:
    """Depth (48, 64) of the plane normal . X = -distance."""
    v, u = np.indices((48, 64))
    rays = np.stack([(u - 31.5) / 60, (v - 23.5) / 60, np.ones((48, 64))], axis=-1)
    return -distance / (rays @ normal)


def test_shading_is_brightest_towards_the_lights_and_missing_without_a_normal():
    towards = {"light": surface.KEY + (0, 0, -0.5), "front": (0, 0, -1.0), "away from the light": (0.8, 0.8, -0.5)}
    normals = np.array(
        [[np.array(n) / np.linalg.norm(n) for n in towards.values()] + [np.zeros(3), np.full(3, np.nan)]],
        dtype=np.float32,
    )
    narrow = np.array([[1e4, 0, 2], [0, 1e4, 0], [0, 0, 1.0]])
    light = surface.shade(normals, narrow)[0]
    assert light[0] > light[2]
    assert light[1] > light[2]
    assert np.isnan(light[3:]).all()
    assert (light[:3] > 0).all()
    assert (light[:3] <= 1).all()


@given(st.integers(0, 2**32 - 1))
def test_the_nearest_point_wins_each_pixel(seed):
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(-1, 1, (400, 2)), rng.uniform(1, 5, 400)]).astype(np.float32)
    points[:, :2] *= points[:, 2:]
    colours = rng.integers(0, 256, (400, 3), dtype=np.uint8)
    canvas = (12, 16)
    pixels = np.floor(surface._frame(points, canvas)).astype(int)
    expected = {}
    for pixel, z, colour in sorted(
        zip(map(tuple, pixels), points[:, 2], colours.tolist(), strict=True), key=lambda hit: -hit[1]
    ):
        expected[pixel] = (z, colour)
    drawn = surface._splat(points, colours, canvas)
    for (u, v), (z, colour) in expected.items():
        if not (0 <= u < 16 and 0 <= v < 12):
            continue
        near = [
            expected[u + du, v + dv]
            for du in (-1, 0, 1)
            for dv in (-1, 0, 1)
            if (u + du, v + dv) in expected and 0 <= u + du < 16 and 0 <= v + dv < 12
        ]
        closest = min(near)
        assert drawn[v, u].tolist() == (closest[1] if closest[0] < np.float32(0.97) * z else colour)


def test_a_turned_plane_has_no_holes_and_fills_the_canvas():
    depth = plane(np.array([0.1, -0.2, -1.0]), 2.0)
    turned = surface.oblique(depth, INTRINSICS, np.full(depth.shape, 0.5))
    covered = (turned != surface.BACKGROUND).any(axis=2)
    assert 0.4 < covered.mean() < 0.95
    for row in covered:
        inside = np.flatnonzero(row)
        assert inside.size == 0 or row[inside[0] : inside[-1] + 1].all()


def test_a_surface_of_nothing_is_background():
    turned = surface.oblique(np.full((48, 64), np.nan), INTRINSICS, np.full((48, 64), np.nan))
    assert (turned == surface.BACKGROUND).all()
