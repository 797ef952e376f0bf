"""The comparison of methods that recognise actions, from end to end, and the pieces that its figures rest on."""

import json
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks.mocap import gibbs, methods, peers, speed
from benchmarks.mocap.problem import by_group, filled, loose, open_problem
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.measurements.motions import mirrored
from ipcli.models.mocap.evaluation import evaluate, make_splits
from ipcli.models.mocap.parameters import MOTION, Decision, Learning
from tests.fixtures.mocap_bodies import ACTIONS, GROUPS
from tests.fixtures.mocap_clips import clip, write

ACTION = next(iter(ACTIONS))
NAMES = ("walk", "kick", "squat")


@pytest.fixture
def lessons():
    """Clips (n, 14) of three actions that differ in where they are and along which coordinates they move, and their
    labels.
    """
    rng = np.random.default_rng(3)
    labels, place = np.repeat(NAMES, 8), np.repeat(np.arange(3), 8)
    wide = np.where(np.arange(14) % 3 == np.arange(3)[:, None], 2.0, 0.3)
    return [rng.normal(6 * at, wide[at], (15, 14)) for at in place], labels


def skip_without(name):
    package = methods.NEEDS.get(name, "sklearn")
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")


SLOW = {"MiniRocket"}  # aeon compiles for a minute or more
CURVES = {methods.LIE_GROUP}  # tells curves apart, not where frames lie: test_lie_group has lessons for it


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name
        for name in methods.METHODS
        if name not in CURVES
    ],
)
def test_every_method_tells_apart_what_lies_apart_whole_and_by_one_frame(name, lessons):
    skip_without(name)
    clips, labels = lessons
    kind, grid = methods.METHODS[name]
    method = kind(**{key: value for key, value in grid[-1].items() if key != "by"})
    method.fit(clips[::2], labels[::2])
    assert list(method.answer(clips[1::2])) == list(labels[1::2])
    assert len(method.answer([one[:1] for one in clips])) == len(clips)
    if hasattr(method, "frame_scores"):
        scores = method.frame_scores(clips[1::2])
        assert [one.shape for one in scores] == [(15, 3)] * 12
        assert (
            np.mean(
                [method.classes[one.argmax(axis=1)] == label for one, label in zip(scores, labels[1::2], strict=True)]
            )
            > 0.95
        )


def test_a_joint_that_is_not_seen_stays_where_it_was_or_will_be():
    track = np.full((5, 2, 3), np.nan)
    track[[1, 3], 0] = [[1.0] * 3, [3.0] * 3]
    assert filled(track)[:, 0, 0].tolist() == [1, 1, 1, 3, 3]
    assert not filled(track)[:, 1].any()


def test_the_common_skeleton_is_that_of_the_people_learnt_from(tmp_path, monkeypatch):
    monkeypatch.setattr("ipcli.io.motion.groups.find", lambda name, skeleton: GROUPS)
    problem = open_problem(write(tmp_path / "x.clips.h5", [clip(ACTION, actor) for actor in range(4)]))
    first, second = np.array([0, 1]), np.array([2, 3])
    by = [problem.described("reposed", train)[0] for train in (first, second)]
    assert np.abs(by[0] - by[1]).max() > 1e-3
    np.testing.assert_array_equal(problem.described("positions", first)[0], problem.described("positions", second)[0])
    assert len(problem.motions.splits) == 2


BRIEF = Learning(frames=60, mixture=Mixture(sweeps=10, burn_in=5))


def handed(tmp_path, monkeypatch):
    """A problem whose third actor does all with the other hand, and the split that asks about him; ours learns less."""
    monkeypatch.setattr(peers, "Learning", lambda mirror: replace(BRIEF, mirror=mirror))
    monkeypatch.setattr("ipcli.io.motion.groups.find", lambda name, skeleton: GROUPS)
    clips = [clip(action, actor) for action in ACTIONS for actor in range(3)]
    clips = [replace(one, motion=mirrored(one.motion, GROUPS)) if one.actor == "cyd" else one for one in clips]
    problem = open_problem(write(tmp_path / "x.clips.h5", clips))
    return problem, make_splits(problem.motions, "subjects", 0, test=["cyd"])[0]


@pytest.mark.parametrize(("name", "setting"), [("k-NN of frames", {"by": "reposed", "k": 1}), (peers.OURS, {})])
def test_mirror_images_of_what_is_learnt_from_teach_the_other_hand(tmp_path, monkeypatch, name, setting):
    if name != peers.OURS:
        skip_without(name)
    problem, split = handed(tmp_path, monkeypatch)
    one, both = (
        peers.measure(problem, name, setting | {"mirror": mirror}, split, ("whole",)) for mirror in (False, True)
    )
    assert both["frames"] > one["frames"] + 0.1
    assert both["whole"] == 1


def test_ours_is_what_the_command_answers_and_what_was_kept_is_not_measured_again(tmp_path, monkeypatch):
    problem, split = handed(tmp_path, monkeypatch)
    told = evaluate(problem.motions, [split], BRIEF, Decision(), 0, unordered=(20,), draws=1)
    result = peers.measure(problem, peers.OURS, {"mirror": False}, split, ())
    for kind, table in (("frames", told["frame_confusion"]), ("shuffled", told["pose_sequence_confusion"])):
        assert result[kind] == table.trace(axis1=1, axis2=2)[0] / table.sum()
    asked = str(tmp_path / "x.clips.h5"), "k-NN of frames", ["ann", "bob"], 0, str(tmp_path / "kept.jsonl")
    first = peers.judged(*asked, quick=True)
    assert list(first["splits"]["leave-one-out"]) == ["test on ann", "test on bob", "test on cyd"]
    monkeypatch.setattr(peers, "measure", lambda *_: {})  # but for what warms up
    assert peers.judged(*asked, quick=True) == first


def test_features_side_by_side_are_told_apart_and_loose_frames_have_no_motion(tmp_path, monkeypatch):
    monkeypatch.setattr("ipcli.io.motion.groups.find", lambda name, skeleton: GROUPS)
    known = open_problem(write(tmp_path / "x.clips.h5", [clip(ACTION, actor) for actor in range(2)]))
    both, alone = (known.described(by, np.arange(2))[0] for by in ("motion", "poses"))
    parts = by_group(both)
    assert [part.shape[1] for part in parts.values()] == [7] * len(GROUPS.parts) + [7 * len(GROUPS.parts) + 4]
    assert MOTION in parts
    assert {name: part for name, part in by_group(alone).items()}.keys() == parts.keys() - {MOTION}
    np.testing.assert_array_equal(np.concatenate(list(by_group(alone).values()), axis=1), alone)
    np.testing.assert_array_equal(loose(alone, "poses"), alone)
    np.testing.assert_array_equal(
        np.isnan(loose(both, "motion")), np.arange(both.shape[1])[None] >= alone.shape[1] + np.zeros((len(both), 1))
    )


def test_protocols_never_share_people_and_choose_on_development_actors_alone(tmp_path, monkeypatch):
    monkeypatch.setattr("ipcli.io.motion.groups.find", lambda name, skeleton: GROUPS)
    problem = open_problem(write(tmp_path / "x.clips.h5", [clip(ACTION, actor) for actor in range(4)]))
    chosen, reported = peers.protocols(problem, ["ann", "bob"], 0)

    def people(rows):
        return {str(name) for name in problem.actors[problem.those_of(rows)]}

    for split in [*chosen, *(one for splits in reported.values() for one in splits)]:
        assert not people(split.train) & people(split.test)
    assert {name for split in chosen for name in people(split.train | split.test)} == {"ann", "bob"}
    assert people(reported["subjects"][0].train) == {"ann", "bob"}
    assert {key: len(splits) for key, splits in reported.items()} == {
        "subjects": 1,
        "leave-one-out": 4,
        "one-to-rest": 4,
    }


@pytest.mark.slow
def test_the_comparison_has_all_its_rows_and_frames_in_any_order_are_the_same_to_what_knows_no_order(tmp_path):
    from ipcli.cli.main import main

    clips = tmp_path / "x.clips.h5"
    assert main(["import-clips", "sample_data/motions", "-o", str(clips)]) == 0
    methods = ["k-NN of frames", "shrinkage LDA of frames", "covariance + linear SVM (Cov3DJ)"]
    peers.main(
        [
            "--clips",
            str(clips),
            "--name",
            "x",
            "--development",
            "ann,bob",
            "--methods",
            *methods,
            "--output",
            str(tmp_path),
        ]
    )
    tables = json.loads((tmp_path / "mocap_peers_x.json").read_text())["tables"]
    by_split = {f"{protocol}, whole clips of each split %" for protocol in ("leave-one-out", "one-to-rest")}
    assert set(tables) == {"subjects", "leave-one-out", "one-to-rest"} | by_split
    for rows in (rows for name, rows in tables.items() if name not in by_split):
        assert [row["method"] for row in rows] == methods
        assert all(row["shuffled clips %"] == row["whole clips %"] for row in rows[:2])


@pytest.mark.slow
def test_the_mixtures_have_all_their_rows_and_ours_finds_the_planted_clusters(tmp_path):
    gibbs.main(["--quick", "--output", str(tmp_path)])
    case, many, density = json.loads((tmp_path / "bayes_gibbs.json").read_text())["tables"].values()
    rows = {row["method"]: row for row in case}
    assert not any("failed" in row for row in case)
    assert rows["ipcli, whole fit"]["VI to the truth"] < 0.2
    assert [row["executor"] for row in many] == ["serial", "processes:2"]
    assert [row["draws"] for row in density] == list(gibbs.DRAWS)


@pytest.mark.slow
def test_a_quick_look_at_the_speed_has_all_its_rows(tmp_path):
    speed.main(["--clips", "sample_data/motions", "--quick", "--output", str(tmp_path)])
    found = json.loads((tmp_path / "mocap_speed.json").read_text())
    learning, steps, commands = found["tables"].values()
    assert [(row["what"], row["executor"]) for row in learning] == [
        (what, executor) for what in speed.MODELS for executor in speed.EXECUTORS
    ]
    assert [row["step"] for row in steps] == ["features", "densities", "answers", "all"]
    assert [row["frames"] for row in commands] == [2000, 4000]
    assert all(row["seconds"] > 0 for rows in (learning, steps, commands) for row in rows)
    assert {"exponent of seconds", "exponent of MB"} <= found["facts"].keys()
