"""A small library: it comes back from its arrays, repeats, and its lights are those that were asked for."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.models.brdf import training
from ipcli.models.brdf.materials import Conductor, Plastic
from ipcli.models.brdf.parameters import LibraryLearning
from ipcli.models.brdf.reflectance import charts

SMALL = LibraryLearning(lights=3, headings=2, scenes=40, pictures=20, side=48, grid=32)


def test_lights_are_probes_at_all_headings_and_then_studios():
    known = training.lights({"room": np.ones((8, 16, 3))}, SMALL, 0)
    assert known.names == ("room", "studio 0", "studio 1", "studio 2")
    np.testing.assert_array_equal(known.probe, [0, 0, 1, 2, 3])
    np.testing.assert_allclose(known.heading[:2], [0, np.pi])
    np.testing.assert_allclose(known.lights[0].radiance, 1)


@pytest.fixture(scope="module")
def library():
    known = training.lights({}, SMALL, 0)
    brdfs = (Conductor((1.2, 1, 0.7), (7, 7, 6), 0.3), Plastic((0.5, 0.1, 0.1), 1.5, 0.2))
    made = np.concatenate([charts(brdf, known.lights, coarse=9) for brdf in brdfs]).clip(0)
    return training.learn(made, ("metal", "red"), np.array([True, False]), known, SMALL, 0)


def test_a_library_is_a_sound_artefact(library):
    schema.validate(schema.kind("brdf-library"), library)


def test_a_red_plastic_is_told_from_a_metal(library):
    assert library["material_accuracy"][0] > 0.8
