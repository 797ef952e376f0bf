"""What "none of these" rests on: everyone is asked about by models that do not know them, and rows are their means."""

import json
import math

import numpy as np
import pytest

from experiments.mocap import refusals
from experiments.mocap.refusals import Development, summary
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap.calibration import POWER
from ipcli.models.mocap.motions import Motions
from ipcli.models.mocap.parameters import Decision, Learning
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every

QUICK = Learning(frames=20, mixture=Mixture(sweeps=2, burn_in=1, moves=0))


@pytest.fixture(scope="module")
def data():
    clips = [one for one in every(frames=8, repeats=1) if one.actor != "dan"]
    return Development.learn(Motions(tuple(clips), GROUPS), QUICK)


def test_the_default_is_among_what_was_tried():
    assert POWER in refusals.JOINED.values()
    assert any(math.isclose(1 - Decision().reject, level) for level in refusals.LEVELS)


def test_nobody_is_asked_about_by_a_model_that_knows_them(data):
    people = len(data.people)
    assert len(data.models) == 2**people - 2
    for who, some, actions in refusals.questions(data, None, False):
        assert who not in some
        assert len(some) == people - 1
        assert len(actions) == len(data.names) - 1


def test_a_fold_knows_the_actions_that_are_left_alone(data):
    who = data.people[0]
    fold = data.fold([who], who, [0, 2])
    assert fold.log_density.shape[1:] == (2, len(fold.model.groups))
    assert sorted({*fold.action.tolist()}) == [-1, 0, 1]
    known = refusals.known_actions(fold)
    assert len(known.action) == (fold.action >= 0).sum() == len(np.unique(known.query))
    assert known.query.max() == len(known.action) - 1


def test_a_summary_weighs_data_sets_alike_and_reads_curves_where_three_in_a_hundred_are_lost():
    strict = (np.linspace(0, 1, 1000, endpoint=False), np.full(10, 0.001))  # loses what it may, catches all
    lax = (np.full(1000, 0.9), np.full(10, 0.95))  # loses none, catches none
    found = summary([[strict], [lax, lax]])
    assert found["lost at 0.05"] == pytest.approx(2.5, abs=0.1)
    assert found["caught at 0.05"] == found["caught where 3% lost"] == 50.0
    assert found["reject there"] == pytest.approx(0.94, abs=0.002)
    assert found["area"] == pytest.approx((1.0 + 0.0) / 2, abs=0.01)


def test_rows_are_of_every_way_and_their_means(data, tmp_path):
    rows = refusals.rows_of([data], Decision())
    refusals.write_table(tmp_path / "r", rows)
    rows = json.loads((tmp_path / "r.json").read_text())["rows"]
    ways = [row["way"] for row in rows if row["trial"] == "mean"]
    assert ways == refusals.WAYS
    for way in ways:
        *trials, mean = [row for row in rows if row["way"] == way]
        assert mean["area"] == pytest.approx(np.mean([row["area"] for row in trials]), abs=1e-3)
