"""The pages of behaviours, recognitions and evaluations, whatever they hold."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli import schema
from ipcli.report.mocap import action_evaluation, action_recognition
from ipcli.report.mocap.action_evaluation import accuracy, mean_and_spread
from tests.fixtures.pages import ESCAPED, HOSTILE, sound
from tests.fixtures.report_artefacts import ACTIONS, GROUPS, evaluation, texts


def recognition_artefact(queries="clip", n=7):
    rng = np.random.default_rng(2)
    posterior = rng.dirichlet(np.ones(3), n)
    answers = ACTIONS[posterior.argmax(axis=1)]
    answers[:1] = "none"
    return {
        "queries": np.array(queries),
        "clips": np.array([f"take {index // 4}" for index in range(n)]),
        "frames": np.full(n, 30),
        "times": np.arange(n)[:, None] + np.array([0.0, 1.0]),
        "actions": ACTIONS,
        "groups": GROUPS,
        "answers": answers,
        "posterior": posterior,
        "group_posterior": rng.random((n, 2)),
        "novelty": rng.random(n),
        "threshold": np.float64(0.9),
        "truth": np.append(ACTIONS, texts(*["kick"] * n))[:n],
    }


def windows():
    arrays = recognition_artefact("window")
    return arrays | {
        "segment_clip": texts("take 0", "take 0", "take 1"),
        "segment_time": np.array([[0, 2], [2, 4], [0, 3.0]]),
        "segment_answer": texts("kick", "none", "squat"),
        "segment_best": texts("kick", "squat", "squat"),
        "segment_posterior": np.array([0.9, 0.4, 0.7]),
        "segment_novelty": np.array([0.1, 2.0, 0.3]),
        "truth_segment_clip": texts("take 0"),
        "truth_segment_time": np.array([[0, 2.0]]),
        "truth_segment_answer": texts("kick"),
    }


def without(arrays, *names):
    return {name: array for name, array in arrays.items() if name not in names}


def variants():
    yield "action-evaluation", "several splits", evaluation()
    yield "action-evaluation", "one split", evaluation(1)
    yield "action-evaluation", "by frames", evaluation() | {"split": np.array("frames")}
    yield "action-evaluation", "nothing tested", evaluation() | {"sequence_confusion": np.zeros((3, 3, 3), np.int64)}
    yield (
        "action-evaluation",
        "no unordered frames",
        evaluation()
        | {"unordered_frames": np.empty(0, np.int64), "unordered_confusion": np.zeros((3, 0, 3, 3), np.int64)},
    )
    yield "action-recognition", "clips", recognition_artefact()
    yield "action-recognition", "one clip", recognition_artefact(n=1)
    yield "action-recognition", "no labels", without(recognition_artefact(), "truth")
    yield "action-recognition", "unordered_frames", recognition_artefact("unordered")
    yield "action-recognition", "windows", windows()
    yield (
        "action-recognition",
        "windows without labels",
        without(windows(), "truth", *(name for name in windows() if name.startswith("truth_"))),
    )
    yield (
        "action-recognition",
        "no frames",
        recognition_artefact() | {"novelty": np.full(7, np.nan), "group_posterior": np.full((7, 2), np.nan)},
    )
    yield (
        "action-recognition",
        "never none",
        recognition_artefact() | {"threshold": np.float64(np.inf), "answers": ACTIONS[np.arange(7) % 3]},
    )


PAGES = {"action-evaluation": action_evaluation.page, "action-recognition": action_recognition.page}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("kind", "arrays"), [pytest.param(kind, arrays, id=f"{kind}-{name}") for kind, name, arrays in variants()]
)
def test_every_variant_is_valid_and_makes_a_sound_page(kind, arrays, provenance):
    schema.validate(schema.kind(kind), arrays)
    html = PAGES[kind](arrays, provenance)
    sound(html)
    assert ESCAPED in html
    assert HOSTILE not in html
    assert html == PAGES[kind](arrays, provenance)


def test_shares_are_those_of_the_counts():
    assert accuracy(np.array([[3, 1], [0, 4]])) == 7 / 8
    assert np.isnan(accuracy(np.zeros((2, 2))))
    assert mean_and_spread(np.array([0.5])) == "50\N{NO-BREAK SPACE}%"
    assert mean_and_spread(np.array([0.4, 0.6, np.nan])) == "50\N{NO-BREAK SPACE}% ± 14.1"


def test_a_protocol_that_leaks_says_so(provenance):
    for split, leaks in (("frames", True), ("clips", True), ("subjects", False), ("leave-one-out", False)):
        html = action_evaluation.page(evaluation() | {"split": np.array(split)}, provenance)
        assert ('class="notice"' in html) == leaks


def test_wrong_clips_are_listed_and_counted(provenance):
    html = action_evaluation.page(evaluation(1), provenance)
    wrong = [index for index in range(12) if index % 5 == 0]
    assert f"{len(wrong)} of 12 clips were named wrong." in html
    assert all((f"clip {index}<" in html) == (index in wrong) for index in range(12))


def test_a_label_that_the_model_does_not_know_gets_its_own_row(provenance):
    arrays = recognition_artefact()
    arrays["truth"][-1] = "dance"
    html = action_recognition.page(arrays, provenance)
    assert html.count("n = 1<") >= 1
    assert ">dance</text>" in html


def test_a_gap_between_segments_is_explained_where_there_is_one():
    assert "A gap: none of the actions." in action_recognition.page(windows(), {})
    named = windows() | {"segment_answer": texts("kick", "squat", "squat")}
    assert "A gap" not in action_recognition.page(named, {})


def test_the_time_named_right_is_that_of_the_overlaps():
    """Of 2 s of kick in take 0 all was named kick, of the 2 s after it 1 s none and 1 s kick; take 1 has no label."""
    arrays = windows() | {
        "segment_time": np.array([[0, 3.0], [3, 4], [0, 3]]),
        "truth_segment_clip": texts("take 0", "take 0"),
        "truth_segment_time": np.array([[0, 2.0], [2, 4]]),
        "truth_segment_answer": texts("kick", "squat"),
    }
    assert action_recognition.shares_of_time(arrays) == (0.5, 0.25)
    assert "50 % was named right and 25 % none" in action_recognition.page(arrays, {}).replace(
        "\N{NO-BREAK SPACE}", " "
    )


def test_labels_that_were_never_learnt_are_scored_apart_and_none_is_right_there():
    arrays = recognition_artefact(n=4) | {
        "answers": np.array(["none", "none", str(ACTIONS[0]), str(ACTIONS[2])]),
        "truth": np.array(["handstand", str(ACTIONS[0]), "handstand", str(ACTIONS[2])]),
    }
    html = action_recognition.page(arrays, {}).replace("\xa0", " ")
    assert "50 % of the 2 whose label the model learnt were named right." in html
    assert "50 % of the 2 of labels that it never learnt were told as none." in html
    assert html.count("not the label that it has") == 1
    assert html.count("of an action that was never learnt") == 1


def test_an_answer_none_names_the_action_that_its_posterior_is_of():
    arrays = recognition_artefact(n=1) | {"posterior": np.array([[0.1, 0.2, 0.7]])}
    assert f"most like {ACTIONS[2]}" in action_recognition.page(arrays, {})
