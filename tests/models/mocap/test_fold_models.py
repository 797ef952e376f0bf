"""The models of all folds judge together, and say the same after they were stored."""

from dataclasses import replace

import numpy as np
import pytest

from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap import behaviours
from ipcli.models.mocap.fold_models import PART, FoldModels, surprise
from ipcli.models.mocap.motions import Motions
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.training import learn
from tests.fixtures.held_out import ACTIONS, clips, fold, model
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import clip, every

QUICK = Learning(frames=30, folds=2, mixture=Mixture(sweeps=4, burn_in=2, thin=1, moves=1))


@pytest.fixture(scope="module")
def learnt():
    return learn(Motions(tuple(every(frames=12, repeats=1)), GROUPS), QUICK, Decision(), 0)


def test_stored_models_judge_as_they_did(learnt):
    known = Motions((clip("kick", 0, repeat=5), clip("bow", 1, repeat=5)), GROUPS)
    features, query = known.features(learnt.lengths, QUICK.features), known.clip
    back = FoldModels.of_arrays(behaviours.arrays(learnt.model) | learnt.judges.arrays())
    found = [
        judges.references[True].novelty(
            judges.measured(judges.log_densities(features), query, 2, Decision(), ordered=True)
        )
        for judges in (learnt.judges, back)
    ]
    assert len(learnt.judges.models) == len(back.models) == 2
    np.testing.assert_array_equal(back.surprise, learnt.judges.surprise)
    assert np.isfinite(found[0]).all()
    np.testing.assert_allclose(found[0], found[1], rtol=1e-3)  # components are stored in single precision


def test_unordered_frames_tell_nothing_of_motion(learnt):
    known = Motions((clip("kick", 0),), GROUPS)
    (density, _) = learnt.judges.log_densities(known.features(learnt.lengths, QUICK.features), ordered=False)
    unseen = np.isnan(density).all(axis=(0, 1))
    assert np.array(learnt.model.groups)[unseen].tolist() == ["motion"]


def test_without_folds_there_is_nobody_to_judge(learnt):
    none = FoldModels.of_folds([], Decision())
    assert (none.models, none.references, len(none.surprise)) == ((), {}, 0)
    back = FoldModels.of_arrays(behaviours.arrays(learnt.model) | none.arrays())
    assert (back.models, len(back.references), len(back.surprise)) == ((), 0, 0)


def test_surprise_is_known_of_parts_of_clips():
    """Each clip of 12 frames has two parts."""
    one = fold(1)
    double = replace(one, query=one.query // 2, action=one.action[::2])
    judges = FoldModels.of_folds([double, double], Decision())
    assert len(judges.surprise) == 2 * len(double.action) * (12 // PART)
    assert (np.diff(judges.surprise) >= 0).all()


def test_unusual_poses_are_surprising():
    density, query = clips(20, np.repeat(np.arange(ACTIONS), 10))
    one, more = (surprise(model(), density - less, query, Decision()) for less in (0.0, 2.0))
    np.testing.assert_allclose(more, one + 1.0)  # a dimension
