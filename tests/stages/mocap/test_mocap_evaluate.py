"""mocap-evaluate writes a sound artefact of the splits asked for, and refuses where there is nothing to tell apart."""

import pytest

from ipcli import schema
from ipcli.errors import ParameterError
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.io.files import h5
from ipcli.models.mocap.parameters import Learning
from ipcli.params import Run
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.mocap import mocap_evaluate
from ipcli.stages.mocap.parameters import MocapEvaluate
from tests.fixtures.mocap_clips import every, write, write_groups

QUICK = Learning(frames=40, mixture=Mixture(sweeps=4, burn_in=2, thin=1))


@pytest.fixture
def source(tmp_path):
    return write(tmp_path / "a.clips.h5", every(frames=12, repeats=1))


def run(source, tmp_path, **given):
    groups = str(write_groups(tmp_path / "groups.toml"))
    params = MocapEvaluate(groups=groups, learning=QUICK, **given)
    return mocap_evaluate.run([source], tmp_path / "x.evaluation.h5", params, Run())


def test_the_artefact_is_sound_and_of_what_was_asked_for(source, tmp_path):
    given = {"split": "published", "only": ("first",), "unordered": (3,), "draws": 2}
    assert run(source, tmp_path, **given) is Outcome.DONE
    found = h5.read(tmp_path / "x.evaluation.h5", "action-evaluation").arrays
    schema.validate(schema.kind("action-evaluation"), found)
    assert str(found["split"]) == "published"
    assert found["splits"].tolist() == ["first"]
    assert found["unordered_frames"].tolist() == [3]
    assert found["unordered_confusion"].sum() == 12
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    assert run(source, tmp_path, **given) is Outcome.UP_TO_DATE


def test_actions_are_left_out_of_one_split(source, tmp_path):
    assert run(source, tmp_path, split="leave-actions-out", only=("first",)) is Outcome.DONE
    found = h5.read(tmp_path / "x.evaluation.h5", "action-novelty").arrays
    assert str(found["people"]) == "first"
    assert len(found["clips"]) == 3 * 3 * 2
    told = mocap_evaluate.figures(tmp_path / "x.evaluation.h5")
    assert list(told) == ["actions", "auc", "unknown_caught", "known_lost", "auc_by_surprise"]
    assert "Unknown actions: 3" in (tmp_path / "x.evaluation.html").read_text(encoding="utf-8")


def test_actions_are_not_left_out_of_several_splits_at_once(source, tmp_path):
    with pytest.raises(ParameterError, match="Name one"):
        run(source, tmp_path, split="leave-actions-out", only=("first", "second"))


def test_of_one_action_there_is_nothing_to_tell_apart(source, tmp_path):
    with pytest.raises(ParameterError, match="at least two"):
        run(source, tmp_path, actions=("kick",))


def test_everybody_on_one_side_is_refused(source, tmp_path):
    with pytest.raises(ParameterError, match="nothing to train on"):
        run(source, tmp_path, test=("ann", "bob", "cyd", "dan"))
