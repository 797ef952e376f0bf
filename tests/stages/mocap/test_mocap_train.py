"""mocap-train writes a sound model and leaves nothing of its work behind."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import ParameterError
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.io.files import h5
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.training import learn_behaviours
from ipcli.params import Run
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.mocap import mocap_train
from ipcli.stages.mocap.parameters import ClipReading, MocapTrain
from ipcli.stages.mocap.reading import read
from tests.fixtures.mocap_bodies import GROUPS
from tests.fixtures.mocap_clips import every, write, write_groups

QUICK = Learning(frames=40, mixture=Mixture(sweeps=4, burn_in=2, thin=1))


@pytest.fixture
def source(tmp_path):
    return write(tmp_path / "a.clips.h5", every(frames=12, repeats=1))


def params(tmp_path, **given):
    return MocapTrain(groups=str(write_groups(tmp_path / "groups.toml")), learning=QUICK, **given)


def test_the_artefact_is_what_the_model_learns_from_the_clips(source, tmp_path):
    output = tmp_path / "x.model.h5"
    assert mocap_train.run([source], output, params(tmp_path), Run(seed=3)) is Outcome.DONE
    found = h5.read(output, "behaviours").arrays
    schema.validate(schema.kind("behaviours"), found)
    expected = learn_behaviours(read([source], ClipReading(), GROUPS), QUICK, Decision(), 3)
    assert {*found} == {*expected}
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    assert mocap_train.run([source], output, params(tmp_path), Run(seed=3)) is Outcome.UP_TO_DATE


def test_a_dry_run_writes_nothing(source, tmp_path):
    given = params(tmp_path)
    before = {*tmp_path.iterdir()}
    assert mocap_train.run([source], tmp_path / "x.model.h5", given, Run(dry_run=True)) is Outcome.WOULD_RUN
    assert {*tmp_path.iterdir()} == before


def test_an_action_that_is_not_there_is_refused(source, tmp_path):
    with pytest.raises(ParameterError, match="kick"):
        mocap_train.run([source], tmp_path / "x.model.h5", params(tmp_path, actions=("kik",)), Run())
    assert not (tmp_path / "x.model.h5").exists()
