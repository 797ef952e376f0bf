"""The pieces of the Lie-group method: where bones lie, what is warped, and its Fourier pyramid."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.mocap import lie_group
from ipcli.geometry import lie


@pytest.fixture
def skeleton():
    rng = np.random.default_rng(5)
    starts = rng.normal(size=(6, 4, 3))
    return starts, starts + rng.normal(size=(6, 4, 3))


def test_each_logarithm_carries_the_axis_onto_the_other_bone(skeleton):
    starts, ends = skeleton
    twists = lie_group.relative_bones(starts, ends).reshape(6, 12, 6)
    motion = lie.se3_exp(twists)
    pairs = [(m, k) for m in range(4) for k in range(4) if m != k]
    for pair, (m, k) in enumerate(pairs):
        local = lie.minimal_rotation(ends[:, m] - starts[:, m]).swapaxes(1, 2)
        start = np.einsum("nij,nj->ni", local, starts[:, k] - starts[:, m])
        end = np.einsum("nij,nj->ni", local, ends[:, k] - starts[:, m])
        length = np.linalg.norm(ends[:, k] - starts[:, k], axis=1)[:, None]
        np.testing.assert_allclose(motion[:, pair, :3, 3], start, atol=1e-9)
        np.testing.assert_allclose(motion[:, pair, :3, 3] + length * motion[:, pair, :3, 0], end, atol=1e-9)


def test_distances_between_bones_do_not_depend_on_where_the_body_is(skeleton):
    """The frame of a bone is fixed but for a turn about it, so what is invariant is moving, and its length."""
    starts, ends = skeleton
    moved = lie_group.relative_bones(starts + 3, ends + 3)
    np.testing.assert_allclose(moved, lie_group.relative_bones(starts, ends), atol=1e-9)
    about_x = Rotation.from_euler("x", 70, degrees=True).as_matrix()
    along_x = np.array([[0.0, 0, 0], [0.3, 0.1, 0.2]])[None], np.array([[1.0, 0, 0], [0.5, 0.4, 0.1]])[None]
    first = lie_group.relative_bones(*along_x).reshape(1, 2, 6)[:, 0]
    turned = lie_group.relative_bones(*(part @ about_x.T for part in along_x)).reshape(1, 2, 6)[:, 0]
    np.testing.assert_allclose(
        turned, np.concatenate([first[:, :3] @ about_x.T, first[:, 3:] @ about_x.T], axis=1), atol=1e-9
    )


def test_a_curve_at_another_speed_is_warped_onto_itself():
    time = np.linspace(0, 1, 60)
    curve = np.stack([np.sin(3 * time), time], axis=1)
    slow = np.repeat(curve, 3, axis=0)
    np.testing.assert_allclose(lie_group.warped(slow, curve), curve, atol=1e-12)
    np.testing.assert_allclose(lie_group.nominal_curve([curve, curve, curve]), curve, atol=1e-12)


def test_the_pyramid_is_of_the_whole_and_of_its_halves():
    curve = np.random.default_rng(1).normal(size=(16, 2))
    found = lie_group.fourier_pyramid(curve, 2)
    whole = np.fft.fft(curve, axis=0)[:4] / 16
    half = np.fft.fft(curve[8:], axis=0)[:2] / 8
    np.testing.assert_allclose(found[:16], np.concatenate([whole.real.ravel(), whole.imag.ravel()]), atol=1e-12)
    np.testing.assert_allclose(found[-8:], np.concatenate([half.real.ravel(), half.imag.ravel()]), atol=1e-12)


def test_curves_of_three_kinds_are_told_apart_at_any_speed():
    rng = np.random.default_rng(8)
    clips, labels = [], []
    for label, turns in (("once", 1), ("twice", 2), ("thrice", 3)):
        for _ in range(10):
            phase = 2 * np.pi * turns * np.linspace(0, 1, int(rng.integers(30, 60)))
            curve = np.stack([np.sin(phase), np.cos(phase), phase / 9], axis=1)
            clips.append(curve + 0.05 * rng.normal(size=curve.shape))
            labels.append(label)
    method = lie_group.WarpedPyramid(stride=1, levels=2, cost=100.0)
    method.fit(clips[::2], np.array(labels[::2]))
    assert method.answer(clips[1::2]).tolist() == labels[1::2]
    assert len(method.answer([clip[:1] for clip in clips])) == len(clips)
