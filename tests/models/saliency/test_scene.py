"""The whole on a wall with two red discs that are looked at in turn: learnt, predicted, bounded, repeatable."""

from functools import cache

import numpy as np
import pytest

from ipcli.errors import NoSolution
from ipcli.measurements.subsequences import PosedSequence
from ipcli.models.saliency import scene
from ipcli.models.saliency.scene_parameters import Classifying, SceneSaliency, SurfaceFit
from ipcli.schema import kind, validate
from tests.fixtures import search

SMALL = SceneSaliency(
    radius=0.2, objects=2, group_size=0, surface=SurfaceFit(nodes=1500), classifying=Classifying(landmarks=60)
)  # fmt: skip


@cache
def found():
    return scene.saliency(search.sequence(), SMALL)


def test_the_artefact_is_whole():
    validate(kind("saliency"), found())


def test_discs_that_are_looked_at_are_predicted_in_subsequences_that_were_not_learnt_from():
    a = found()
    assert np.nanmean(a["folds/rates"][:, 4]) < 0.15
    ranking = dict(zip(a["rankings"].tolist(), np.nanmean(a["subsequences/ranking"], axis=0), strict=True))
    assert ranking["learnt function"] > 0.95
    (now, now_chance), (ever, ever_chance) = a["hits"].tolist()
    assert ever > 5 * ever_chance
    assert now > 3 * now_chance


def test_proto_objects_lie_on_red_discs_and_never_on_the_blue_one():
    places = found()["objects/places"]
    off = np.linalg.norm(places[:, None] - search.DISCS, axis=2)
    assert (off[:, :2].min(axis=1) < 0.2).mean() > 0.8
    assert (off[:, 2] > 0.2).all()


def test_the_saliency_of_points_is_high_on_red_and_low_elsewhere():
    a = found()
    off = np.linalg.norm(a["points/places"][:, None] - search.DISCS, axis=2)
    assert a["points/saliency"][off[:, :2].min(axis=1) < 0.1].mean() > 0.7
    assert a["points/saliency"][off.min(axis=1) > 0.5].mean() < 0.2


def test_what_was_learnt_predicts_a_recording_without_gaze():
    function = scene.model_of(found())
    a = scene.saliency(search.sequence(2, gaze=False), SMALL, [function])
    off = np.linalg.norm(a["objects/places"][:, None] - search.DISCS[:2], axis=2).min(axis=1)
    assert (off < 0.2).mean() > 0.7
    assert (a["objects/hit"] == -1).all()
    assert "model/columns" not in a


def test_without_gaze_or_a_function_membranes_alone_predict_and_it_is_said():
    a = scene.saliency(search.sequence(2, gaze=False), SMALL)
    validate(kind("saliency"), a)
    assert "Membranes alone" in a["notes"][0]
    assert scene.model_of(a) is None
    assert np.isnan(a["hits"]).all()


def test_twice_the_same_is_the_same_to_the_last_bit():
    again = scene.saliency(search.sequence(), SMALL)
    for name, array in found().items():
        assert array.tobytes() == again[name].tobytes(), name


def test_no_surface_anywhere_is_no_solution():
    sequence = search.sequence()
    blind = PosedSequence(
        1, lambda k: scene_without_points(sequence), sequence.camera, (), sequence.regards, sequence.regard_frames, "x"
    )  # fmt: skip
    with pytest.raises(NoSolution, match="no surface"):
        scene.saliency(blind, SMALL)


def scene_without_points(sequence):
    from dataclasses import replace

    return replace(sequence.load(0), cloud=np.empty((0, 3)))
