"""Materials told by their patches: two that could not differ more, and no surface or probe is used twice."""

import numpy as np
import pytest

from experiments.brdf import looks
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.material import STATISTICS, Classifier
from ipcli.models.brdf.reflectance import chart_normals
from ipcli.models.brdf.rim import FEATURES, Judge


@pytest.fixture(scope="module")
def shelf():
    """A red matte and a blue one with a mirror's lobe, under six lights each."""
    n = chart_normals()
    lights = [np.array([np.cos(a), np.sin(a), 1.0]) / np.sqrt(2) for a in range(6)]
    matte = [np.clip(n @ light, 0, 1)[..., None] * [0.9, 0.2, 0.1] for light in lights]
    shiny = [np.clip(n @ light, 0, 1)[..., None] ** 40 * [0.2, 0.3, 1.0] + 0.05 for light in lights]
    count = len(STATISTICS)
    classifier = Classifier(np.zeros((count, 2)), np.array([1.0, 0.0]), np.zeros(count), np.ones(count), 1.0)
    judge = Judge(np.zeros(len(FEATURES) + 1), np.zeros(len(FEATURES)), np.ones(len(FEATURES)))
    charts, material, probe = np.stack([*matte, *shiny]), np.repeat([0, 1], 6), np.tile(np.arange(6), 2)
    return Library(charts, material, probe, ("matte", "shiny"), tuple("abcdef"), judge, classifier)


def test_patches_tell_them_apart(shelf):
    told = looks.shares(shelf, np.array([False, True]), quick=True)
    assert set(told) == {*looks.WAYS, *looks.LEARNT, looks.LIBRARY}
    assert told["divergence and error"] == (1.0, 1.0)
    assert told[looks.LIBRARY] == (0.5, 0.5)  # this one always says matte


def test_every_use_has_probes_and_surfaces_of_its_own(shelf):
    masks = {use: [mask for _, mask in looks.pictures(shelf, 0, use, 2)] for use in looks.PICTURES}
    flat = [mask.tobytes() for shown in masks.values() for mask in shown]
    assert len(set(flat)) == len(flat)
