"""The kernel of agreement against whole-array geometry."""

import numpy as np
import pytest

from ipcli.geometry.cameras import back_project, project, rays, transform
from ipcli.kernels.agreement import ask
from tests.fixtures.fusion_scenes import camera, pose_at

TOLERANCE, RELATIVE, COSINE, GRAZING = 2.0, 0.02, 0.3, 0.1


def random_map(rng, shape, turn, shift):
    """A rough wall with holes, noise, confidence and counts, and normals that mostly face the camera."""
    depth = (2 + 0.3 * np.linspace(-1, 1, shape[1]) + rng.normal(0, 0.05, shape)).astype(np.float32)
    depth[rng.random(shape) < 0.1] = np.nan
    facing = rng.normal((0, 0, -1), 0.6, (*shape, 3))
    facing[rng.random(shape) < 0.1] = (1, 0, 0.01)  # along the wall
    facing = (facing / np.linalg.norm(facing, axis=2, keepdims=True)).astype(np.float32)
    noise, confidence = (rng.uniform(0.01, 0.05, shape).astype(np.float32) for _ in range(2))
    observations = rng.integers(1, 9, shape).astype(np.uint16)
    return depth, facing, noise, confidence, observations, camera(shape, 0.8), pose_at(shift, turn)


def twin(own, other):
    """(sums, votes) of `ask`, all pixels at once."""
    depth, normals, *_, intrinsics, pose = own
    seen, facing, noise, confidence, observations, seen_intrinsics, seen_pose = other
    h, w = seen.shape
    motion = seen_pose @ np.linalg.inv(pose)
    moved = transform(motion, back_project(depth.astype(np.float64), intrinsics))
    place = np.floor(project(moved, seen_intrinsics) + 0.5)
    inside = ((place >= 0) & (place < (w, h))).all(axis=2)
    column, row = np.where(inside[..., None], place, 0).astype(int).transpose(2, 0, 1)
    at, plane = seen[row, column].astype(np.float64), facing[row, column].astype(np.float64)
    ray = moved / moved[..., 2:]
    along = (plane * ray).sum(axis=2)
    tilted = np.abs(along) > GRAZING * np.linalg.norm(ray, axis=2)
    crossing = at * (plane * rays(seen.shape, seen_intrinsics)[row, column]).sum(axis=2)
    there = np.where(tilted, crossing / np.where(tilted, along, 1), at)
    limit = np.maximum(TOLERANCE * noise[row, column], RELATIVE * at)
    apart = moved[..., 2] - there
    through = inside & (apart < -limit)
    agrees = inside & (np.abs(apart) <= limit) & ((plane * (normals @ motion[:3, :3].T)).sum(axis=2) >= COSINE)
    precision = observations[row, column] * (confidence[row, column].astype(np.float64) / noise[row, column]) ** 2
    where = transform(np.linalg.inv(motion), there[..., None] * ray)
    sums = np.concatenate(
        [where * precision[..., None], np.stack([precision, confidence[row, column]], axis=2)], axis=2
    )
    return np.where(agrees[..., None], sums, 0), np.stack([agrees, through], axis=2)


@pytest.mark.parametrize("turn", [0.0, 0.05, -0.4, 3.0])
@pytest.mark.parametrize("shapes", [((24, 32), (24, 32)), ((40, 21), (9, 50)), ((1, 7), (5, 1))], ids=str)
def test_ask_is_the_geometry_of_whole_arrays(shapes, turn):
    rng = np.random.default_rng(5)
    own = random_map(rng, shapes[0], 0.0, (0, 0, 0))
    other = random_map(rng, shapes[1], turn, (0.113, -0.057, 0.021))
    sums, votes = np.zeros((*shapes[0], 5)), np.zeros((*shapes[0], 2), np.uint16)
    motion = other[-1] @ np.linalg.inv(own[-1])
    limits = (TOLERANCE, RELATIVE, COSINE, GRAZING)
    with np.errstate(invalid="ignore"):
        expected_sums, expected_votes = twin(own, other)
    for _ in range(2):  # it adds
        ask(
            sums,
            votes,
            *own[:2],
            np.linalg.inv(own[-2]),
            motion,
            *other[:5],
            np.linalg.inv(other[-2]),
            other[-2],
            limits,
        )
    np.testing.assert_array_equal(votes, 2 * expected_votes)
    np.testing.assert_allclose(sums, 2 * expected_sums, rtol=1e-9, atol=1e-9)
    if shapes[0] == shapes[1] and abs(turn) < 0.1:
        agrees, through = expected_votes.reshape(-1, 2).T
        assert agrees.sum() > 50
        assert through.sum() > 50
        assert not (agrees & through).any()
