"""What is left out is not learnt by any of the models, and is asked about."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.errors import ParameterError
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap import evaluation, left_out
from ipcli.models.mocap.motions import Motions
from ipcli.models.mocap.parameters import Decision, Features, Learning
from ipcli.models.mocap.training import fit_in_turn
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every, take

QUICK = Learning(
    frames=30, features=Features(motion=0.0, body=False), mixture=Mixture(sweeps=4, burn_in=2, thin=1, moves=1)
)


def known():
    return Motions(tuple(every(frames=12, repeats=1)), GROUPS)


def test_clips_of_an_action_are_left_out_and_frames_of_it_have_no_label():
    motions = Motions((*known().clips, take()), GROUPS)
    found = left_out.without(motions, "kick")
    assert "kick" not in found.labels
    assert len(found.clips) == len(motions.clips) - 4
    assert len(found.clips[-1].motion.positions) == len(take().motion.positions)
    assert (found.clips[-1].frame_labels == "").sum() == 45


def test_an_action_that_is_left_out_is_in_no_cell_and_its_clips_are_asked_about():
    cells = []

    def fit(points):
        cells.append(tuple(points))
        return fit_in_turn(points, QUICK, 0)

    motions = known()
    (split,) = evaluation.make_splits(motions, "subjects", 0, test=("dan",))
    found = left_out.evaluate_left_out(motions, split, QUICK, Decision(), 0, fit)
    assert found["left_out"].tolist() == ["bow", "kick", "wave"]
    for name, own in zip(found["left_out"], cells, strict=True):
        assert all(cell.startswith(f"without {name}: ") for cell in own)
        assert not any(f" {name}, " in cell.removeprefix(f"without {name}:") for cell in own)
        assert {cell.split(": ")[1] for cell in own if "fold" in cell} == {"fold 1", "fold 2", "fold 3"}
    assert sorted(found["truth"].tolist()) == ["bow"] * 3 + ["kick"] * 3 + ["wave"] * 3
    assert all("_dan_" in name for name in found["clips"])
    assert (found["best"] != found["left_out"][found["query_left_out"]]).all()
    assert np.isfinite(found["novelty"]).all()


def test_two_actions_are_too_few():
    motions = replace(known(), clips=tuple(one for one in known().clips if one.label != "bow"))
    (split,) = evaluation.make_splits(motions, "subjects", 0, test=("dan",))
    with pytest.raises(ParameterError, match="at least 3"):
        left_out.evaluate_left_out(motions, split, QUICK, Decision(), 0)


def test_without_a_second_person_there_is_nothing_to_calibrate_on():
    motions = known()
    people = {"bow": "ann", "kick": "bob", "wave": "cyd"}
    motions = replace(motions, clips=tuple(c for c in motions.clips if c.actor in ("dan", people[c.label])))
    (split,) = evaluation.make_splits(motions, "subjects", 0, test=("dan",))
    with pytest.raises(ParameterError, match="nothing to calibrate on"):
        left_out.evaluate_left_out(motions, split, QUICK, Decision(), 0)
