"""The averages of cells against a dictionary of cells, however the points come in."""

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.models.fusion import cells
from ipcli.models.fusion.cells import Cells, SurfacePoints, concatenate
from tests.fixtures.fusion_scenes import pose_at

SPACING = 0.25


def some_points(rng, count, color=True):
    normal = rng.normal((0, 0, -2), 1, (count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    colors = rng.integers(0, 256, (count, 3), np.uint8) if color else None
    return SurfacePoints(
        rng.uniform(-1, 1, (count, 3)),
        normal,
        colors,
        rng.uniform(1, 9, count),
        rng.uniform(0, 2, count),
        rng.integers(2, 9, count),
    )


def by_dictionary(points):
    """Cell -> (position, unit normal, colour, precision, confidence, views)."""
    members = {}
    for i, place in enumerate(points.position):
        members.setdefault(tuple(np.floor(place / SPACING).astype(int)), []).append(i)
    means = {}
    for cell, inside in members.items():
        weights = points.precision[inside]
        position, normal, color, confidence = (
            np.average(values[inside], axis=0, weights=weights)
            for values in (points.position, points.normal, points.color, points.confidence)
        )
        unit = normal / np.linalg.norm(normal)
        means[cell] = (position, unit, np.rint(color), weights.sum(), confidence, points.views[inside].max())
    return means


@pytest.mark.parametrize("waiting", [0, 40, 10**9])
def test_cells_hold_the_weighted_means_whatever_the_parts_they_come_in(waiting, monkeypatch):
    monkeypatch.setattr(cells, "WAITING", waiting)
    rng = np.random.default_rng(2)
    parts = [some_points(rng, count) for count in (0, 300, 1, 0, 150, 700)]
    grid = Cells(SPACING)
    for part in parts:
        grid.add(part)
    found, expected = grid.points(), by_dictionary(concatenate(parts))
    assert len(found.position) == len(expected)
    for i, (_, values) in enumerate(sorted(expected.items())):
        fields = (found.position, found.normal, found.color, found.precision, found.confidence, found.views)
        for got, wanted in zip(fields, values, strict=True):
            np.testing.assert_allclose(got[i], wanted, rtol=1e-12, atol=1e-12)


def test_what_waits_is_bounded_by_the_cells(monkeypatch):
    monkeypatch.setattr(cells, "WAITING", 100)
    grid, rng = Cells(1.0), np.random.default_rng(3)
    for _ in range(50):
        grid.add(some_points(rng, 60))
        assert sum(len(key) for key, _ in grid._parts) <= 100 + 8


def test_colours_are_left_out_when_a_part_has_none():
    rng = np.random.default_rng(4)
    grid = Cells(SPACING)
    grid.add(some_points(rng, 9))
    grid.add(some_points(rng, 9, color=False))
    assert grid.points().color is None


def test_no_points_are_no_cells_and_too_many_cells_are_refused():
    grid = Cells(SPACING)
    grid.add(some_points(np.random.default_rng(0), 0))
    assert len(grid.points().position) == 0
    with pytest.raises(ParameterError, match="cells along an axis"):
        Cells(1e-7).add(some_points(np.random.default_rng(0), 9))


def test_moved_points_are_turned_and_shifted():
    points, motion = some_points(np.random.default_rng(1), 5), pose_at((1.0, 2.0, 3.0), 0.4)
    back = points.transform(motion).transform(np.linalg.inv(motion))
    np.testing.assert_allclose(back.position, points.position, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(points.transform(motion).normal, axis=1), 1)
    assert np.abs(points.transform(motion).normal - points.normal).max() > 0.1


def test_a_cloud_that_grows_too_large_is_refused_with_the_cure(monkeypatch):
    monkeypatch.setattr(cells, "WAITING", 0)
    found = Cells(SPACING, most=50)
    with pytest.raises(ParameterError, match=r"merge.spacing: 0.25 makes a cloud of more than 50 points.*--max-memory"):
        found.add(some_points(np.random.default_rng(0), 400))
