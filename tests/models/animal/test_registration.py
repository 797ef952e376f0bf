"""Registration: known transforms come back, whichever surface is the reference; derivatives by their slopes."""

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from ipcli.geometry.lie import affine_exp
from ipcli.inverse.regularize.least_absolute import deviation, primal_dual, reweighted
from ipcli.models.animal import registration
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import Inflation, Registration
from ipcli.models.animal.registration import AspectSurface


def club() -> tuple[np.ndarray, np.ndarray]:
    """A limb with a thick end."""
    rows, columns = np.mgrid[:50, :70]
    mask = np.hypot(columns - 22, rows - 25) < 13
    mask |= (np.abs(rows - 25 - 0.25 * (columns - 22)) < 5) & (columns > 22) & (columns < 60)
    return inflate(mask, Inflation(triangles=300)).surface()


def moved(vertices: np.ndarray, transform: np.ndarray) -> np.ndarray:
    return vertices @ transform[:3, :3].T + transform[:3, 3]


def similarity(turn, scale, shift) -> np.ndarray:
    transform = np.eye(4)
    transform[:3, :3] = scale * Rotation.from_rotvec(turn).as_matrix()
    transform[:3, 3] = shift
    return transform


MIDDLE = similarity([0, 0, 0], 1.0, [35, 25, 0])
TRUTH = MIDDLE @ similarity([0.1, -0.08, 0.5], 1.15, [12, -7, 0.5]) @ np.linalg.inv(MIDDLE)


@pytest.fixture(scope="module")
def surfaces():
    vertices, faces = club()
    return AspectSurface.of(moved(vertices, TRUTH), faces), AspectSurface.of(vertices, faces)


@pytest.mark.parametrize("method", ["primal-dual", "irls"])
def test_a_known_similarity_is_found_whichever_is_the_reference(surfaces, method):
    first, second = surfaces
    there = registration.register(first, second, Registration(method))
    back = registration.register(second, first, Registration(method))
    away = np.abs(moved(second.vertices, there.transform) - first.vertices).max()
    assert away < 0.25
    assert np.abs(moved(second.vertices, there.start) - first.vertices).max() > 2
    assert np.abs(moved(second.vertices, there.transform @ back.transform) - second.vertices).max() < 0.4
    assert there.residual < 0.01


def test_affine_maps_find_a_stretching(surfaces):
    first, second = surfaces
    stretched = similarity([0, 0, 0.1], 1.0, [3, 2, 0]) @ np.diag([1.15, 0.95, 1.0, 1.0])
    target = AspectSurface.of(moved(second.vertices, stretched), second.faces)
    found = registration.register(target, second, Registration(group="affine"), np.eye(4))
    alike = registration.register(target, second, Registration(group="similarity"), np.eye(4))
    assert np.abs(moved(second.vertices, found.transform) - target.vertices).max() < 0.5
    assert alike.residual > 3 * found.residual


def hills(spacing=0.3, size=40, beyond=6) -> AspectSurface:
    """Smooth heights that reach beyond their picture, so that no rim moves through it."""
    axis = np.arange(-beyond, size + beyond, spacing)
    u, v = np.meshgrid(axis, axis)
    heights = 6 + 7 * np.exp(-((u - 17) ** 2 + (v - 22) ** 2) / 162) + 4 * np.exp(-((u - 28) ** 2 + (v - 12) ** 2) / 98)
    grid = np.arange(u.size).reshape(u.shape)
    a, b, c, d = grid[:-1, :-1].ravel(), grid[:-1, 1:].ravel(), grid[1:, :-1].ravel(), grid[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    vertices = np.stack([u, v, -heights], axis=-1).reshape(-1, 3)
    corner = np.zeros(2, int)
    return AspectSurface(vertices, faces, corner, registration.rendered(vertices, faces, corner, (size, size)))


@pytest.mark.parametrize("step", [1, 4])
def test_what_the_jacobian_leaves_falls_with_the_square_of_the_step(step):
    """Taylor: |p(exp(t dxi) T) - p(T) - t J dxi| is a quarter when t is halved, in both pictures; a wrong J: a half."""
    surface = hills()
    middle = similarity([0, 0, 0], 1, [20, 20, 0])
    near = middle @ similarity([0.03, -0.02, 0.1], 1.03, [0.7, -0.6, 0.4]) @ np.linalg.inv(middle)
    basis = registration.generators("affine", np.array([20.0, 20.0, 0.0]), 13.0)
    p, slopes = registration.linearised(surface, surface, near, basis, step)
    dxi = np.random.default_rng(0).normal(size=len(basis))
    left = []
    for t in (1.0, 0.5, 0.25, 0.125):
        stepped = affine_exp(np.tensordot(t * dxi, basis, 1)) @ near
        left.append(np.abs(registration.deviations(surface, surface, stepped, step) - p - t * slopes @ dxi).mean())
    assert np.log2(np.divide(left[:-1], left[1:])) == pytest.approx(2.0, abs=0.25)  # .125: facets of the hills
    assert left[0] < 0.1 * np.abs(slopes @ dxi).mean()


def test_the_linear_problem_has_one_optimum_for_three_solvers(surfaces):
    first, second = surfaces
    basis = registration.generators("similarity", first.middle, 15.0)
    near = affine_exp(np.tensordot([0.8, -0.5, 0.2, 0.3, 0.2, 0.5, 0.3], basis, 1)) @ TRUTH
    p, slopes = registration.linearised(first, second, near, basis, 4)
    told = slopes.any(axis=1)
    p, slopes = p[told], slopes[told]
    above = np.block([[slopes, -np.eye(len(p))], [-slopes, -np.eye(len(p))]])
    cost = np.concatenate([np.zeros(7), np.ones(len(p))])
    best = linprog(cost, above, np.concatenate([-p, p]), bounds=[(-2, 2)] * 7 + [(0, None)] * len(p)).fun
    for solve in (primal_dual, reweighted):
        assert best - 1e-6 <= deviation(p, slopes, solve(p, slopes, 2.0)) <= 1.005 * best
    assert best < 0.7 * np.abs(p).sum()


def test_matches_give_a_start_in_space(surfaces):
    first, second = surfaces
    at = second.vertices[second.vertices[:, 2] < -2][::8]
    matches = np.stack([moved(at, TRUTH)[:, :2], at[:, :2]], axis=1)
    start = registration.match_start(first, second, matches)
    assert np.abs(moved(at, start) - moved(at, TRUTH)).max() < 1.0
    with pytest.raises(ValueError, match="matches"):
        registration.match_start(first, second, matches[:3])


def test_pairs_are_brought_in_tune_whatever_the_order():
    rng = np.random.default_rng(3)
    world = [similarity(0.3 * rng.normal(size=3), 1 + 0.1 * rng.random(), rng.normal(size=3)) for _ in range(4)]
    pairs = [[np.linalg.inv(a) @ b for b in world] for a in world]
    pairs[0][3] = pairs[3][0] = None
    for k, j in ((0, 1), (1, 2), (0, 2)):  # what each pair found is a little off
        pairs[k][j] = pairs[k][j] @ similarity(0.01 * rng.normal(size=3), 1.0, 0.02 * rng.normal(size=3))
        pairs[j][k] = np.linalg.inv(pairs[k][j])
    common = registration.synchronised(pairs)
    order = [2, 0, 3, 1]
    again = registration.synchronised([[pairs[i][j] for j in order] for i in order])
    for i in range(4):
        for j in range(4):
            found = np.linalg.inv(common[order[i]]) @ common[order[j]]
            assert np.abs(found - np.linalg.inv(again[i]) @ again[j]).max() < 1e-3
            assert np.abs(found - np.linalg.inv(world[order[i]]) @ world[order[j]]).max() < 0.1
    with pytest.raises(ValueError, match="no pair connects"):
        registration.synchronised([[None, None], [None, None]])
