"""The two-point energy (6.10): 0 at the truth of a known body, its terms by hand, its minimum, proposition 6.1."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from ipcli.geometry.raycast import Caster, Mesh
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal import two_point as tp
from ipcli.models.animal.two_point import OutlinePoints, SurfaceSamples

AXES = np.array([0.5, 0.8, 1.1])
ROTATION = Rotation.from_euler("xyz", [0.4, -0.7, 1.1]).as_matrix()


def ellipsoid(points):
    """Samples of the ellipsoid at unit vectors (n, 3), exactly."""
    at = points * AXES
    slope = at / AXES**2
    normals = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    gauss = 1 / (AXES.prod() ** 2 * (at**2 / AXES**4).sum(axis=1) ** 2)
    mean = np.abs((at**2).sum(axis=1) - (AXES**2).sum()) / (2 * AXES.prod() ** 2 * (slope**2).sum(axis=1) ** 1.5)
    root = np.sqrt(np.maximum(mean**2 - gauss, 0))
    return SurfaceSamples(at, normals, mean - root, mean + root, 2 * float(np.linalg.norm(AXES)))


def rim(angles):
    """Unit vectors (n, 3) of points on the contour generator, and the outline's points there, exactly."""
    view = ROTATION[2] / AXES  # a point u of the unit sphere is on the rim where <u / AXES, v> = 0
    one = np.linalg.svd(view[None])[2][1:]
    units = np.cos(angles)[:, None] * one[0] + np.sin(angles)[:, None] * one[1]
    shape = ROTATION[:2] * AXES @ one.T  # of the ellipse, from the circle
    first = -np.sin(angles)[:, None] * shape[:, 0] + np.cos(angles)[:, None] * shape[:, 1]
    second = -np.cos(angles)[:, None] * shape[:, 0] - np.sin(angles)[:, None] * shape[:, 1]
    turn = np.sign(np.linalg.det(shape))
    speed = np.linalg.norm(first, axis=1)
    curvature = turn * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    normals = turn * np.stack([first[:, 1], -first[:, 0]], axis=1) / speed[:, None]
    return units, OutlinePoints((units * AXES) @ ROTATION[:2].T, normals, curvature)


@pytest.fixture(scope="module")
def scene():
    """Samples of the ellipsoid of which the first two are those of the outline, its mesh, and the outline's pair."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    units, pair = rim(np.array([0.3, 1.7]))
    samples = ellipsoid(np.concatenate([units, np.asarray(ball.vertices)[::9]]))
    return samples, Mesh(np.asarray(ball.vertices) * AXES, np.asarray(ball.faces)), pair


def test_the_energy_is_0_at_the_truth_and_gives_the_view(scene):
    samples, body, pair = scene
    costs = tp.pair_costs(samples, pair)
    assert costs[0, 1] == pytest.approx(0, abs=1e-12)
    assert (costs >= 0).all()
    base = samples.points[1] - samples.points[0]  # (6.15) as printed is not 0 here, it has the depth in it
    assert np.linalg.norm(base) > 1.02 * np.linalg.norm(pair.points[1] - pair.points[0])
    rotations, energies = tp.views(samples, pair, body, 1)
    assert energies[0] < 0.05  # the rays pass a thousandth outside an ellipsoid, whose mesh is a little smaller
    assert np.allclose(rotations[0], ROTATION, atol=1e-6)


def test_each_term_by_hand(scene):
    samples, _, pair = scene
    costs = tp.pair_costs(samples, pair)
    view = ROTATION[2]
    for i, j in ((0, 5), (7, 1), (11, 30)):
        n, y = samples.normals[[i, j]], samples.points[[i, j]]
        v = np.cross(*n) * np.sign(np.cross(*np.pad(pair.normals, ((0, 0), (0, 1))))[2])
        sine = np.linalg.norm(v)
        if sine <= tp.CROSSED:
            assert costs[i, j] == np.inf
            continue
        v /= sine
        base = (y[1] - y[0]) - ((y[1] - y[0]) @ v) * v
        turn = np.arccos(np.clip(n[0] @ base / np.linalg.norm(base), -1, 1)) * np.sign(np.cross(n[0], base) @ v)
        flat = pair.points[1] - pair.points[0]
        asked = [np.arctan2(*(u[::-1])) for u in (*pair.normals, flat)]
        off = [np.arccos(n[0] @ n[1]) - np.arccos(pair.normals[0] @ pair.normals[1]), turn - (asked[2] - asked[0])]
        wrapped = [abs(np.angle(np.exp(1j * a))) for a in off]
        length = (np.linalg.norm(base) - np.linalg.norm(flat)) / samples.size
        bent = sum(
            tp.CURVATURE * samples.size * abs(k - np.clip(k, samples.least[at], samples.largest[at]))
            for k, at in zip(pair.curvature, (i, j), strict=True)
        )
        by_hand = bent + np.tan(wrapped[0] / 2) + np.tan(wrapped[1] / 2) + tp.DISTANCE * length**2
        assert costs[i, j] == pytest.approx(by_hand)
    assert abs(view @ tp.view_directions(samples, pair, np.array([0]), np.array([1]))[1][0]) == pytest.approx(1)


def test_the_best_first_search_finds_what_brute_force_does(scene):
    samples, body, pair = scene
    some = samples.chosen(np.arange(0, len(samples.points), 2))
    rotations, energies = tp.views(some, pair, body, 12, chunk=20)
    again, brute = tp.views(some, pair, body, 12, chunk=10**9)  # all pairs' rays at once
    assert energies == pytest.approx(brute, abs=1e-9)
    assert np.allclose(rotations[0], again[0])


def test_least_sums_ask_no_more_than_they_must():
    rng = np.random.default_rng(1)
    known, extra = rng.random(5000), rng.exponential(0.2, 5000)
    known[::7] = np.inf
    asked = []

    def penalty(some):
        asked.extend(some.tolist())
        return extra[some]

    found, values = tp.least_sums(known, penalty, 10, chunk=50)
    order = np.argsort(known + extra)[:10]
    assert np.array_equal(found, order)
    assert values == pytest.approx((known + extra)[order])
    assert len(asked) < 1500
    assert len(tp.least_sums(known[:3], penalty, 10)[0]) == 2  # no more than there are


def test_proposition_61_is_false_at_a_hyperbolic_point_and_the_corrected_cost_is_0_there():
    """z = -(a x^2 + 2 b x y + c y^2) / 2 seen along x: its outline is z = -(c - b^2 / a) y^2 / 2."""
    a, b, c = 1.0, 1.0, 0.5
    outline = c - b**2 / a
    least, largest = np.linalg.eigvalsh([[a, b], [b, c]])
    y = np.linspace(-0.01, 0.01, 5)
    x = np.linspace(-0.5, 0.5, 100001)
    top = np.array([(-(a * x**2 + 2 * b * x * s + c * s**2) / 2).max() for s in y])
    assert np.polyfit(y, top, 2)[0] == pytest.approx(-outline / 2, abs=1e-4)
    assert outline < least < 0 < largest  # (6.12) would have it in [least, largest]
    rim = np.array([-b / a, 1.0])  # where the slope along x is 0
    sine = 1 / np.linalg.norm(rim)  # of the angle between x and the rim
    normal_curvature = rim @ [[a, b], [b, c]] @ rim * sine**2
    assert normal_curvature == pytest.approx(sine**2 * outline)  # (6.11), of the rim's normal curvature
    assert outline < least <= normal_curvature < 0
    point = SurfaceSamples(np.zeros((1, 3)), np.eye(3)[2:], np.array([least]), np.array([largest]), 1.0)
    assert tp.curvature_cost(point, outline)[0] == 0
    assert tp.curvature_cost(point, 0.5 * least)[0] == pytest.approx(-tp.CURVATURE * 0.5 * least)
    assert tp.curvature_cost(point, 0.5 * largest)[0] == tp.SIGN  # inside the interval, but of the wrong sign


def test_the_deepest_stretch_of_a_line_through_two_balls():
    small, large = (trimesh.creation.icosphere(subdivisions=4, radius=r) for r in (0.2, 0.3))
    vertices = np.concatenate([small.vertices - [0.5, 0, 0], large.vertices + [0.4, 0, 0]])
    caster = Caster(Mesh(vertices, np.concatenate([small.faces, large.faces + len(small.vertices)])))
    points = np.array([[-0.5, 0.05, 0.01], [0.9, 0.15, 0.02], [0.0, 0.25, 0.01], [0.0, 0.6, 0.0]])
    found = caster.deepest(points, np.tile([1.0, 0, 0], (4, 1)))
    exact = [2 * np.sqrt(0.09 - off**2) for off in (np.hypot(0.05, 0.01), np.hypot(0.15, 0.02), np.hypot(0.25, 0.01))]
    assert found == pytest.approx([*exact, 0.0], abs=0.004)


def test_an_outline_gives_points_normals_and_curvature_away_from_other_parts():
    v, u = np.mgrid[:120, :160]
    labels = (np.hypot(u - 60, v - 60) < 40).astype(np.int16)
    labels[50:70, 95:150][labels[50:70, 95:150] == 0] = 2
    scale = 10.0
    found = OutlinePoints.of(PartImage("a", labels), 0, scale)
    outward = found.points * scale - [60, 60]
    assert np.linalg.norm(outward, axis=1) == pytest.approx(40, abs=1)
    assert ((found.normals * outward).sum(axis=1) > 0.98 * 39).all()
    assert np.median(found.curvature) == pytest.approx(scale / 40, rel=0.1)
    away = np.abs(np.arctan2(outward[:, 1], outward[:, 0]))
    assert 0.25 < away.min() < 0.7  # the limb begins at asin(10 / 40)
    assert len(found.points) > 100


def test_a_pair_is_where_few_samples_fit_and_normals_cross(scene):
    samples, _, _ = scene
    _, outline = rim(np.linspace(0, 2 * np.pi, 60, endpoint=False))
    pair = outline.pair(samples)
    sharpest = np.argmin([(tp.curvature_cost(samples, k) == 0).mean() for k in outline.curvature])
    assert np.array_equal(pair.points[0], outline.points[sharpest])
    assert abs(np.linalg.det(pair.normals)) > tp.CROSSED
    spiky = OutlinePoints(outline.points, outline.normals, np.full(60, 1e4))
    assert spiky.pair(samples) is None
