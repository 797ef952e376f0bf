"""mocap-classify writes answers and a table of them, and says so when there is nothing to answer by."""

import re
from dataclasses import replace

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import NoSolution, ParameterError
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.io.files import h5
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.params import Run
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.mocap import mocap_classify, mocap_train
from ipcli.stages.mocap.parameters import ClipReading, MocapClassify, MocapTrain
from tests.fixtures.mocap_clips import clip, every, take, write, write_groups


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("model")
    source = write(folder / "a.clips.h5", every())
    learning = Learning(frames=60, mixture=Mixture(sweeps=8, burn_in=4, thin=2))
    params = MocapTrain(
        groups=str(write_groups(folder / "groups.toml")), actors=("ann", "bob", "cyd"), learning=learning
    )
    assert mocap_train.run([source], folder / "x.model.h5", params, Run()) is Outcome.DONE
    return folder / "x.model.h5"


def classify(model, folder, clips, **given):
    source = write(folder / "asked.clips.h5", clips)
    return mocap_classify.run(model, [source], folder / "y.recognition.h5", MocapClassify(**given), Run())


def test_answers_are_those_of_the_artefact_and_of_the_table(model, tmp_path):
    asked = [clip("kick", 3), clip("wave", 3)]
    assert classify(model, tmp_path, asked) is Outcome.DONE
    found = h5.read(tmp_path / "y.recognition.h5", "action-recognition").arrays
    schema.validate(schema.kind("action-recognition"), found)
    told = mocap_classify.answers(tmp_path / "y.recognition.h5")
    assert [answer["answer"] for answer in told] == ["kick", "wave"]
    assert [answer["posterior_of_best"] for answer in told] == found["posterior"].max(axis=1).tolist()
    lines = (tmp_path / "y.recognition.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "clip,start_s,end_s,action,best,posterior_of_best,novelty,frames,actor,label"
    expected = [
        f"{a['clip']},0.000,0.800,{a['answer']},{a['best']},{a['posterior_of_best']:.4f},{a['novelty']:.4g},24,"
        f"{asked[n].actor},{asked[n].label}"
        for n, a in enumerate(told)
    ]
    assert lines[1:] == expected


def test_what_is_not_known_is_empty_in_the_table_and_no_column_of_nothing(model, tmp_path):
    classify(model, tmp_path, [replace(clip("kick", 3), actor="", label="")], least=1.0)
    head, row = (tmp_path / "y.recognition.csv").read_text(encoding="utf-8").splitlines()
    assert head.endswith(",novelty,frames")
    told = dict(zip(head.split(","), row.split(","), strict=True))
    assert (told["action"], told["best"]) == ("none", "kick")
    assert float(told["posterior_of_best"]) > 0.5
    assert mocap_classify._cell(float("nan"), ".4g") == ""


def test_the_console_counts_answers_and_those_that_are_right(model, tmp_path):
    classify(model, tmp_path, [clip("kick", 3), clip("wave", 3)], none=False)
    output = tmp_path / "y.recognition.h5"
    told = mocap_classify.summary(output)
    right = told.pop("right")
    assert told == {"output": output, "clips": 2, "answered": {"kick": 1, "wave": 1}}
    assert right.value == {"count": 2, "of": 2, "share": 1.0}
    assert str(right) == "2 of 2 whose label the model learnt (100.0%)"


def test_a_label_that_was_never_learnt_is_counted_apart(model, tmp_path):
    classify(model, tmp_path, [clip("kick", 3), replace(clip("wave", 3), label="swim")], none=False)
    told = mocap_classify.summary(tmp_path / "y.recognition.h5")
    assert told["right"].value == {"count": 1, "of": 1, "share": 1.0}
    assert told["none"].value == {"count": 0, "of": 1, "share": 0.0}
    assert str(told["none"]) == "0 of 1 whose label it never learnt (0.0%)"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"window": 0.5, "step": 1.0}, "--step 1 is longer than --window 0.5: the frames in between are seen by no"),
        ({"window": 60.0}, "1 of 1 clips, such as .*, are shorter than --window 60: each is asked about as a whole"),
        ({"window": 0.001}, "--window 0.001 is shorter than a frame: each window is one frame"),
        ({"window": 0.5}, None),
    ],
)
def test_windows_that_are_not_what_one_expects_are_said_to_be(model, tmp_path, caplog, given, said):
    classify(model, tmp_path, [take()], none=False, **given)
    warnings = [record.message for record in caplog.records if "--window" in record.message]
    assert len(warnings) == (said is not None)
    assert all(re.search(said, warning) for warning in warnings)


def test_a_window_of_no_length_is_wrong_usage(model, tmp_path):
    with pytest.raises(ParameterError, match=r"--window 0: a window has a length.*Leave the option out"):
        classify(model, tmp_path, [take()], window=0.0)


def test_of_windows_the_table_has_the_segments(model, tmp_path):
    classify(model, tmp_path, [take()], window=0.5, none=False)
    found = h5.read(tmp_path / "y.recognition.h5", "action-recognition").arrays
    lines = (tmp_path / "y.recognition.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[3] for line in lines[1:]] == found["segment_answer"].tolist()
    told = mocap_classify.answers(tmp_path / "y.recognition.h5")
    assert [one["answer"] for one in told] == found["segment_answer"].tolist()
    assert [[one["start"], one["end"]] for one in told] == found["segment_time"].tolist()
    assert [one["best"] for one in told] == found["segment_best"].tolist()
    assert lines[0] == "clip,start_s,end_s,action,best,posterior_of_best,novelty"
    assert len(found["answers"]) > len(found["segment_answer"])
    assert float(found["segment_time"][-1, 1]) == pytest.approx(4.5)


def test_unordered_frames_are_asked_about_by_their_poses_alone(model, tmp_path):
    classify(model, tmp_path, [clip("kick", 3)], unordered=4, draws=3)
    found = h5.read(tmp_path / "y.recognition.h5", "action-recognition").arrays
    assert str(found["queries"]) == "unordered"
    assert found["frames"].tolist() == [4, 4, 4]
    assert np.isnan(found["group_posterior"][:, found["groups"].tolist().index("motion")]).all()


def test_below_the_least_posterior_the_answer_is_none(model, tmp_path):
    classify(model, tmp_path, [take()], window=0.5, reading=ClipReading())
    plain = h5.read(tmp_path / "y.recognition.h5", "action-recognition").arrays
    least = float(np.median(plain["posterior"].max(axis=1)))
    source = tmp_path / "asked.clips.h5"
    mocap_classify.run(model, [source], tmp_path / "z.h5", MocapClassify(window=0.5, least=least), Run())
    found = h5.read(tmp_path / "z.h5", "action-recognition").arrays
    unsure = found["posterior"].max(axis=1) < least
    assert unsure.any()
    assert (found["answers"] == np.where(unsure, "none", plain["answers"])).all()


def test_a_model_without_folds_is_still_asked(model, tmp_path):
    """Surprise decides."""
    stored = h5.read(model, "behaviours")
    alone = {name: x for name, x in stored.arrays.items() if not name.startswith(("held_out_", "fold_"))}
    assert len(alone) < len(stored.arrays)
    h5.write(tmp_path / "alone.model.h5", "behaviours", alone, stored.provenance)
    source = write(tmp_path / "asked.clips.h5", [clip("kick", 3), clip("wave", 3)])
    mocap_classify.run(tmp_path / "alone.model.h5", [source], tmp_path / "y.h5", MocapClassify(), Run())
    found = h5.read(tmp_path / "y.h5", "action-recognition").arrays
    assert float(found["threshold"]) == np.quantile(alone["novelty"], Decision().reject)
    assert (found["posterior"].argmax(axis=1) == [1, 2]).all()


@pytest.mark.parametrize("asked", [{}, {"motion": False}])
def test_of_whole_clips_p_values_decide(model, tmp_path, asked):
    classify(model, tmp_path, [clip("kick", 3), clip("kick", 3, frames=4, repeat=1)], **asked)
    found = h5.read(tmp_path / "y.recognition.h5", "action-recognition").arrays
    assert float(found["threshold"]) == pytest.approx(-np.log10(1 - Decision().reject))
    assert np.isfinite(found["novelty"]).tolist() == [True, False]  # four frames are too few
    assert found["answers"][1] == "kick"


def test_a_window_has_all_its_frames(model, tmp_path):
    with pytest.raises(ParameterError, match="exclude each other"):
        classify(model, tmp_path, [take()], window=1.0, unordered=3)


def test_where_no_group_is_ever_seen_whole_there_is_no_answer(model, tmp_path):
    """Every bone is seen at times, so that the body has a height, but in no frame all joints of a group."""
    torn = clip("kick", 3)
    positions, names = torn.motion.positions.copy(), torn.motion.skeleton.joints
    positions[::2, names.index("hips")] = np.nan
    ends = [n for n, name in enumerate(names) if name == "head" or name.endswith(("hand", "foot"))]
    positions[1::2, ends] = np.nan
    torn = replace(torn, motion=replace(torn.motion, positions=positions, rotations=None))
    with pytest.raises(NoSolution, match="asked.clips.h5: no frame shows any group of joints whole"):
        classify(model, tmp_path, [torn])
    assert not (tmp_path / "y.recognition.h5").exists()
