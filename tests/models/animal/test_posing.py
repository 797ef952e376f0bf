from dataclasses import replace

import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.geometry.orthographic import of_view
from ipcli.geometry.part_masks import framed, render
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal import posing
from ipcli.models.animal.articulation import Posture, jointed
from ipcli.models.animal.limbs import TREE, four_legged


@pytest.fixture(scope="module")
def body():
    vertices, faces, labels, tree = four_legged(spacing=0.045)
    return jointed(vertices, faces, labels - 1, tree)


def looks(body, vertices, views=("left", "front", "top")):
    images, cameras = [], []
    for view in views:
        camera, shape = framed(vertices, of_view(view), 160)
        seen, _ = render(vertices, body.faces, body.face_part + 1, camera, shape)
        images.append(PartImage(view, seen, view))
        cameras.append(camera)
    return images, cameras


def test_the_gradient_is_the_slope_of_the_value(body):
    rng = np.random.default_rng(1)
    images, cameras = looks(body, body.vertices)
    targets = [posing.Target.of(i, c, rng) for i, c in zip(images, cameras, strict=True)]
    samples = posing.samples_of(body, rng)
    fitting = posing.Fitting(body, targets, body.size, robust=0.05)
    free = np.ones(len(body), bool)
    start = Posture.rest(body).turned(body, 0.1 * rng.normal(size=(len(body), 3)), np.array([0.05, 0.02, -0.03]), 0.05)

    def system(pose):
        return fitting._system(pose, samples, free, True, None)

    _, gradient, _ = system(start)
    step = rng.normal(size=len(gradient))
    step /= np.linalg.norm(step)
    slopes = []
    for length in (1e-5, 1e-6):
        ahead, behind = (system(fitting._stepped(start, s * length * step, free, True))[2] for s in (1, -1))
        slopes.append((ahead - behind) / (2 * length))
    assert slopes[-1] == pytest.approx(2 * gradient @ step, rel=0.06)  # distances have kinks: 0.033 here


@pytest.mark.slow
def test_a_bent_body_is_found_in_its_images(body):
    """Head and one leg were turned: both are found again, and the rest stays."""
    leg, head = (np.flatnonzero(body.part == TREE.names.index(name))[0] for name in ("front_leg_L", "head"))
    truth = Posture.rest(body)
    turns = truth.turns.copy()
    turns[leg], turns[head] = lie.exp(np.array([0, 0.6, 0.0])), lie.exp(np.array([0, 0.0, 0.4]))
    truth = replace(truth, turns=turns)
    images, cameras = looks(body, truth.skinned(body))
    pose = posing.fit(body, body, images, cameras)
    apart = np.linalg.norm(pose.skinned(body) - truth.skinned(body), axis=1)
    assert apart.mean() < 0.012 * body.size
    assert lie.angle(pose.turns[leg], turns[leg]) < 0.3
    assert posing.likeness(pose.skinned(body), body, images, cameras) > 0.85
