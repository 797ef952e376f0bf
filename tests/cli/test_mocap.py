"""The mocap commands from the command line: what they name, and one line for whatever goes wrong."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from ipcli import schema
from ipcli.cli.main import main, mocap_classify, mocap_train
from ipcli.geometry.skeleton import Skeleton
from ipcli.io.files import h5
from ipcli.measurements.motions import Clip, Motion, mirrored
from tests.fixtures.mocap_bodies import ACTIONS, GROUPS
from tests.fixtures.mocap_clips import QUICK, clip, every, take, write, write_groups


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with clips, groups, and a model of all but one person."""
    folder = tmp_path_factory.mktemp("mocap")
    write(folder / "all.clips.h5", every())
    write_groups(folder / "groups.toml")
    assert mocap_train([str(folder / "all.clips.h5"), *model_options(folder)]) == 0
    return folder


def model_options(folder, name="model.h5"):
    return ["-o", str(folder / name), "--groups", str(folder / "groups.toml"), "--actors", "ann,bob,cyd", *QUICK]


@pytest.fixture
def tell(place, tmp_path, capsys):
    """Run a command on paths; the exit code, stdout and stderr."""

    def run(command, *arguments, output="x.h5"):
        code = main([command, *map(str, arguments), "-o", str(tmp_path / "out" / output)])
        return code, *capsys.readouterr()

    return run


def fails(told, code, *messages):
    assert told[0] == code
    assert told[1] == ""
    assert told[2].count("\n") == 1
    assert told[2].startswith("Error: ")
    for message in messages:
        assert message in told[2]


def test_the_model_is_sound_and_a_page_stands_beside_it(place):
    found = h5.read(place / "model.h5", "behaviours").arrays
    schema.validate(schema.kind("behaviours"), found)
    assert list(found["actions"]) == sorted(ACTIONS)
    assert list(found["actors"]) == ["ann", "bob", "cyd"]
    assert list(found["frames"]) == [144] * 3
    assert list(found["clips"]) == [6] * 3
    assert found["behaviour_poses"].shape[1:] == (4, 16, 3)
    shares = np.zeros((3, len(found["groups"])))
    np.add.at(shares, (found["behaviour_action"], found["behaviour_group"]), found["behaviour_share"])
    np.testing.assert_allclose(shares, 1)
    assert list(found["groups"][-2:]) == ["body", "motion"]
    page = (place / "model.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert page.rstrip().endswith("</html>")
    assert all(f">{name}<" in page for name in (*found["actions"], *found["groups"]))
    assert not [path for path in place.iterdir() if path.name.startswith(".")]


def test_training_again_is_up_to_date_and_any_executor_gives_the_same_bytes(place, tmp_path, capsys):
    assert main(["mocap-train", str(place / "all.clips.h5"), *model_options(place)]) == 0
    assert "up to date" in capsys.readouterr().err
    assert (
        main(
            [
                "mocap-train",
                str(place / "all.clips.h5"),
                *model_options(place)[2:],
                "-o",
                str(tmp_path / "m.h5"),
                "--executor",
                "processes:2",
            ]
        )
        == 0
    )
    assert (tmp_path / "m.h5").read_bytes() == (place / "model.h5").read_bytes()
    assert (tmp_path / "m.html").read_bytes() == (place / "model.html").read_bytes()


def test_a_person_never_seen_is_named_right_whole_and_by_a_few_frames(place, tell, tmp_path):
    asked = write(tmp_path / "dan.clips.h5", [one for one in every() if one.actor == "dan"])
    code, out, _ = tell("mocap-classify", place / "model.h5", asked, "--json")
    told = json.loads(out)
    assert code == 0
    assert all(answer["clip"].startswith(answer["answer"]) for answer in told["answers"])
    code, out, _ = tell(
        "mocap-classify", place / "model.h5", asked, "--json", "--unordered", "5", "--draws", "3", output="few.h5"
    )
    told = json.loads(out)["answers"]
    assert len(told) == 18
    assert {answer["frames"] for answer in told} == {5}
    assert np.mean([answer["clip"].startswith(answer["answer"]) for answer in told]) > 0.9
    rows = list(csv.DictReader((tmp_path / "out" / "x.csv").open()))
    assert len(rows) == 6
    assert all(row["clip"].startswith(row["action"]) for row in rows)
    assert (tmp_path / "out" / "x.html").is_file()


def test_a_long_take_is_parted_where_its_actions_change(place, tell, tmp_path):
    asked = write(tmp_path / "take.clips.h5", [take()])
    assert tell("mocap-classify", place / "model.h5", asked, "--window", "0.5", "--step", "0.1", "--no-none")[0] == 0
    rows = list(csv.DictReader((tmp_path / "out" / "x.csv").open()))
    assert [row["action"] for row in rows] == list(ACTIONS)
    ends = [float(row["end_s"]) for row in rows]
    np.testing.assert_allclose(ends, [1.5, 3.0, 4.5], atol=0.3)
    assert [row["start_s"] for row in rows[1:]] == [row["end_s"] for row in rows[:-1]]
    assert float(rows[0]["start_s"]) == 0
    found = h5.read(tmp_path / "out" / "x.h5", "action-recognition").arrays
    np.testing.assert_allclose(found["truth_segment_time"], [[0, 1.5], [1.5, 3], [3, 4.5]])


def test_what_was_never_learnt_is_none_unless_it_must_be_something(place, tell, tmp_path):
    odd = clip("wave", 0)
    rng = np.random.default_rng(0)
    motion = Motion(odd.motion.skeleton, odd.motion.positions + rng.normal(0, 0.7, odd.motion.positions.shape), 30.0)
    asked = write(tmp_path / "odd.clips.h5", [Clip("odd", motion, "", "ann")])
    answer = json.loads(tell("mocap-classify", place / "model.h5", asked, "--json")[1])["answers"][0]
    assert answer["answer"] == "none"
    forced = json.loads(tell("mocap-classify", place / "model.h5", asked, "--json", "--no-none", output="y.h5")[1])[
        "answers"
    ][0]
    assert forced["answer"] in ACTIONS
    assert forced["novelty"] == answer["novelty"]


def test_the_order_of_frames_and_missing_ones_change_nothing_or_little(place, tell, tmp_path):
    whole = clip("kick", 3)
    shuffled = replace(
        whole.motion, positions=whole.motion.positions[::-1].copy(), rotations=whole.motion.rotations[::-1].copy()
    )
    torn = whole.motion.positions.copy()
    torn[::2, 5] = np.nan
    torn[1::5] = np.nan
    clips = [
        whole,
        replace(whole, name="back", motion=shuffled),
        replace(whole, name="torn", motion=replace(whole.motion, positions=torn)),
    ]
    answers = json.loads(
        tell("mocap-classify", place / "model.h5", write(tmp_path / "c.clips.h5", clips), "--json")[1]
    )["answers"]
    assert [answer["answer"] for answer in answers] == ["kick"] * 3
    assert answers[0]["novelty"] == pytest.approx(answers[1]["novelty"], abs=0.3)  # motion goes the other way
    assert answers[2]["frames"] < answers[0]["frames"]
    assert tell("mocap-classify", place / "model.h5", tmp_path / "c.clips.h5", "--no-motion", output="y.h5")[0] == 0
    moving, alone = (
        h5.read(tmp_path / "out" / name, "action-recognition").arrays["posterior"] for name in ("x.h5", "y.h5")
    )
    np.testing.assert_allclose(alone[0], alone[1], rtol=1e-6)
    assert (moving[0] > 2 * moving[1]).any() or (moving[1] > 2 * moving[0]).any()


@pytest.mark.parametrize(
    ("split", "splits", "more"),
    [
        ("subjects", 1, ["--test", "dan,ann"]),
        ("leave-one-out", 4, []),
        ("one-to-rest", 4, []),
        ("published", 2, []),
        ("clips", 2, ["--repeats", "2"]),
        ("frames", 1, []),
    ],
)
def test_every_protocol_is_evaluated(place, tell, tmp_path, split, splits, more):
    options = ["--groups", place / "groups.toml", "--split", split, *more, *QUICK]
    assert tell("mocap-evaluate", place / "all.clips.h5", *options)[0] == 0
    found = h5.read(tmp_path / "out" / "x.h5", "action-evaluation").arrays
    assert len(found["splits"]) == splits
    assert list(found["unordered_frames"]) == [20, 5, 1]
    frames, clips = found["frame_confusion"], found["sequence_confusion"]
    assert (frames.sum(axis=(1, 2)) == found["test_frames"]).all()
    assert (clips.sum(axis=(1, 2)) == found["test_clips"]).all()
    assert np.trace(clips.sum(axis=0)) > 0.9 * clips.sum()
    assert np.trace(frames.sum(axis=0)) > 0.8 * frames.sum()
    if split == "frames":
        assert found["train_frames"] + found["test_frames"] == 576
    else:
        assert (found["train_clips"] + found["test_clips"] == 24).all()
    assert (tmp_path / "out" / "x.html").is_file()
    assert list(found["groups"][-2:]) == ["body", "motion"]
    assert found["pose_frame_confusion"].sum() == frames.sum()


def test_an_evaluation_of_some_people_actions_and_splits_is_of_those_alone(place, tell, tmp_path):
    usual = ["--groups", place / "groups.toml", *QUICK]
    some = ["--actors", "bob,cyd,dan", "--actions", "kick,bow", "--split", "published", "--only", "second"]
    assert tell("mocap-evaluate", place / "all.clips.h5", *usual, *some)[0] == 0
    found = h5.read(tmp_path / "out" / "x.h5", "action-evaluation").arrays
    assert list(found["splits"]) == ["second"]
    assert list(found["classes"]) == ["bow", "kick"]
    assert found["train_clips"] == [8]
    assert found["test_clips"] == [4]
    assert {name.split("_")[1] for name in found["clips"]} == {"cyd"}
    told = tell(
        "mocap-evaluate", place / "all.clips.h5", *usual, "--split", "published", "--only", "frist", output="y.h5"
    )
    fails(told, 2, "no published split 'frist'", "'first'")


@pytest.fixture(scope="module")
def still(place):
    """A model of the same people that knows poses alone."""
    assert mocap_train([str(place / "all.clips.h5"), *model_options(place, "still.h5"), "--motion", "0"]) == 0
    return place / "still.h5"


def posteriors(tell, tmp_path, *arguments):
    """The posteriors that mocap-classify gives."""
    assert tell("mocap-classify", *arguments, output="p.h5")[0] == 0
    found = h5.read(tmp_path / "out" / "p.h5", "action-recognition").arrays["posterior"]
    (tmp_path / "out" / "p.h5").unlink()
    return found


def test_a_model_without_motion_answers_by_poses_alone(place, still, tell, tmp_path):
    """Clips, takes and single frames, as it does when told to."""
    stored = h5.read(still, "behaviours")
    assert stored.provenance["params"]["learning"]["features"]["motion"] == 0
    assert "motion" not in stored.arrays["groups"]
    clips = write(tmp_path / "dan.clips.h5", [one for one in every() if one.actor == "dan"])
    for asked, options in ((clips, []), (write(tmp_path / "take.clips.h5", [take()]), ["--window", "0.5"])):
        told = posteriors(tell, tmp_path, still, asked, *options)
        np.testing.assert_array_equal(told, posteriors(tell, tmp_path, still, asked, *options, "--no-motion"))
    names = json.loads(tell("mocap-classify", still, clips, "--json")[1])["answers"]
    assert all(answer["clip"].startswith(answer["answer"]) for answer in names)


def test_motion_is_turned_off_by_a_flag_by_the_environment_and_by_a_file_alike(place, still, tmp_path, monkeypatch):
    options = [str(place / "all.clips.h5"), *model_options(place)[2:]]
    (tmp_path / "poses.toml").write_text("[learning.features]\nmotion = 0.0\n")
    assert mocap_train([*options, "-o", str(tmp_path / "file.h5"), "--config", str(tmp_path / "poses.toml")]) == 0
    monkeypatch.setenv("IPCLI_LEARNING__FEATURES__MOTION", "0")
    assert mocap_train([*options, "-o", str(tmp_path / "environment.h5")]) == 0
    assert (tmp_path / "file.h5").read_bytes() == (tmp_path / "environment.h5").read_bytes() == still.read_bytes()


def test_a_single_frame_is_a_clip_whose_motion_is_not_known(place, still, tell, tmp_path):
    whole = clip("bow", 3)
    one = replace(whole.motion, positions=whole.motion.positions[12:13], rotations=whole.motion.rotations[12:13])
    asked = write(tmp_path / "one.clips.h5", [replace(whole, motion=one)])
    for model in (place / "model.h5", still):
        answer = json.loads(tell("mocap-classify", model, asked, "--json", output=f"{model.stem}.h5")[1])["answers"][0]
        assert (answer["answer"], answer["frames"]) == ("bow", 1)
        np.testing.assert_array_equal(
            posteriors(tell, tmp_path, model, asked), posteriors(tell, tmp_path, model, asked, "--no-motion")
        )


def test_an_evaluation_without_motion_is_that_of_poses(place, tell, tmp_path):
    options = ["--groups", place / "groups.toml", "--split", "subjects", "--motion", "0", *QUICK]
    assert tell("mocap-evaluate", place / "all.clips.h5", *options)[0] == 0
    found = h5.read(tmp_path / "out" / "x.h5", "action-evaluation").arrays
    assert "motion" not in found["groups"]
    assert found["group_frame_accuracy"].shape == (1, len(found["groups"]))
    for what in ("frame", "sequence"):
        np.testing.assert_array_equal(found[f"{what}_confusion"], found[f"pose_{what}_confusion"])
    assert np.trace(found["sequence_confusion"][0]) > 0.9 * found["sequence_confusion"].sum()


@pytest.fixture(scope="module")
def both(place):
    """A model of the same people that learnt their mirror images too."""
    assert mocap_train([str(place / "all.clips.h5"), *model_options(place, "both.h5"), "--mirror"]) == 0
    return place / "both.h5"


def test_what_was_learnt_of_one_hand_is_known_of_the_other_with_mirror_images_alone(place, both, tell, tmp_path):
    """All waved with the right hand; now one waves with the left, and one kicks with the other leg."""
    left = [
        replace(one, name=f"{one.name}_left", motion=mirrored(one.motion, GROUPS))
        for one in (clip("wave", 3), clip("kick", 3))
    ]
    asked = write(tmp_path / "left.clips.h5", left)
    models = (both, place / "model.h5")
    knows, does_not = (
        json.loads(tell("mocap-classify", model, asked, "--json", output=model.name)[1])["answers"] for model in models
    )
    assert [answer["answer"] for answer in knows] == ["wave", "kick"]
    assert all(one["novelty"] < other["novelty"] for one, other in zip(knows, does_not, strict=True))
    found, plain = (h5.read(model, "behaviours").arrays for model in models)
    for name in ("frames", "clips", "actors"):
        np.testing.assert_array_equal(found[name], plain[name])
    assert len(found["novelty"]) == len(plain["novelty"])


def test_an_evaluation_learns_mirror_images_and_asks_about_none(place, tell, tmp_path):
    clips = [
        one if one.actor in ("ann", "cyd") else replace(one, motion=mirrored(one.motion, GROUPS)) for one in every()
    ]
    asked = write(tmp_path / "hands.clips.h5", clips)
    told = {}
    for name, more in (("both", ["--mirror"]), ("one", [])):
        assert (
            tell("mocap-evaluate", asked, "--groups", place / "groups.toml", *more, *QUICK, output=f"{name}.h5")[0] == 0
        )
        told[name] = h5.read(tmp_path / "out" / f"{name}.h5", "action-evaluation").arrays
        assert (told[name]["train_frames"], told[name]["test_frames"]) == (288, 288)
    right = {name: np.trace(found["frame_confusion"][0]) / 288 for name, found in told.items()}
    assert right["both"] > 0.9
    assert right["both"] > right["one"] + 0.1


def test_only_the_people_that_are_asked_for_are_recognised(place, tell):
    code, out, _ = tell("mocap-classify", place / "model.h5", place / "all.clips.h5", "--actors", "dan,bob", "--json")
    assert code == 0
    assert {answer["clip"].split("_")[1] for answer in json.loads(out)["answers"]} == {"dan", "bob"}
    told = tell("mocap-classify", place / "model.h5", place / "all.clips.h5", "--actors", "don", output="y.h5")
    fails(told, 2, "no actor 'don'", "'dan'")


def renamed(motion, name="spine"):
    joints = tuple(name if joint == "chest" else joint for joint in motion.skeleton.joints)
    return replace(motion, skeleton=Skeleton(joints, motion.skeleton.parents))


def test_a_model_of_another_skeleton_is_refused(place, tell, tmp_path):
    other = clip("kick", 0)
    asked = write(tmp_path / "other.clips.h5", [replace(other, motion=renamed(other.motion))])
    fails(
        tell("mocap-classify", place / "model.h5", asked), 1, "other.clips.h5", "another skeleton", "no joint 'chest'"
    )


def test_a_file_that_is_no_model_or_no_clips_is_refused(place, tell):
    fails(
        tell("mocap-classify", place / "all.clips.h5", place / "all.clips.h5"),
        1,
        "all.clips.h5",
        "expected behaviours, got clips",
    )
    fails(tell("mocap-train", place / "model.h5"), 1, "model.h5", "expected clips, got behaviours")
    fails(tell("mocap-train", place / "nothing.h5"), 1, "nothing.h5", "cannot be read")


def test_clips_without_labels_teach_nothing(place, tell, tmp_path):
    bare = write(tmp_path / "bare.clips.h5", [replace(one, label="") for one in every(repeats=1)])
    fails(
        tell("mocap-train", bare, "--groups", place / "groups.toml"), 2, "none of the clips has a label", "--manifest"
    )


def test_an_action_of_one_frame_is_named(place, tell, tmp_path):
    clips = [*every(repeats=1), replace(clip("bow", 0, frames=1), name="tiny", label="nod")]
    told = tell("mocap-train", write(tmp_path / "tiny.clips.h5", clips), "--groups", place / "groups.toml", *QUICK)
    fails(told, 2, "nod", "1 frame")


def changed(motion, joint, value):
    """The motion with a joint somewhere else."""
    positions = motion.positions.copy()
    positions[:, motion.skeleton.joints.index(joint)] = value(positions)
    return replace(motion, positions=positions, rotations=None)


def test_a_joint_that_is_never_seen_spoils_its_groups_by_name(place, tell, tmp_path):
    """For learning; recognition goes on with the other groups, and says so when none is left."""
    lost = [replace(one, motion=changed(one.motion, "left_hand", lambda x: np.nan)) for one in every(repeats=1)]
    asked = write(tmp_path / "lost.clips.h5", lost)
    fails(
        tell("mocap-train", asked, "--groups", place / "groups.toml", *QUICK),
        2,
        "'left_arm'",
        "in no frame",
        "groups file",
    )
    told = tell("mocap-classify", place / "model.h5", asked, "--json", "--actors", "dan")
    assert told[0] == 0
    assert all(answer["clip"].startswith(answer["answer"]) for answer in json.loads(told[1])["answers"])
    for one in lost:  # now a side of the body in turn: which way it faces is not known
        for frame, positions in enumerate(one.motion.positions):
            side = ("left", "right")[frame % 2]
            positions[[one.motion.skeleton.joints.index(f"{side}_{joint}") for joint in ("hip", "shoulder")]] = np.nan
    fails(
        tell("mocap-classify", place / "model.h5", write(tmp_path / "gone.clips.h5", lost), output="y.h5"),
        3,
        "gone.clips.h5",
        "no frame shows",
    )


def test_bones_without_length_are_no_body(place, tell, tmp_path):
    clips = every(repeats=1)
    flat = [
        *clips[:-1],
        replace(
            clips[-1],
            name="dot",
            motion=replace(clips[-1].motion, positions=clips[-1].motion.positions * 0 + 1.0, rotations=None),
        ),
    ]
    asked = write(tmp_path / "flat.clips.h5", flat)
    for command, first in (("mocap-train", []), ("mocap-classify", [place / "model.h5"])):
        groups = [] if first else ["--groups", place / "groups.toml"]
        fails(tell(command, *first, asked, *groups, output=f"{command}.h5"), 2, "clip 'dot'", "the body has no height")


def test_a_joint_that_the_groups_file_makes_up_is_named(place, tell, tmp_path):
    text = (place / "groups.toml").read_text().replace("'left_foot'", "'left_fot'")
    (tmp_path / "wrong.toml").write_text(text)
    fails(
        tell("mocap-train", place / "all.clips.h5", "--groups", tmp_path / "wrong.toml"),
        2,
        "wrong.toml",
        "no joint 'left_fot'",
        "'left_foot'",
    )


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        (["--actors", "anne"], ["no actor 'anne'", "'ann'"]),
        (["--actions", "wawe"], ["no action 'wawe'", "'wave'"]),
        (["--groups", "acclaims"], ["no groups 'acclaims'", "acclaim"]),
        (["--features", "printed"], ["features", "printed"]),
        (["--groups", "auto"], ["no groups of joints fit this skeleton", "--groups"]),
        (["--groups", "acclaim"], ["acclaim", "no joint"]),
    ],
)
def test_wrong_usage_is_exit_2_and_names_what_was_meant(place, tell, arguments, messages):
    usual = [] if "--groups" in arguments else ["--groups", place / "groups.toml"]
    fails(tell("mocap-train", place / "all.clips.h5", *usual, *arguments, *QUICK), 2, *messages)


def test_a_window_and_unordered_frames_exclude_each_other(place, tell):
    told = tell("mocap-classify", place / "model.h5", place / "all.clips.h5", "--window", "1", "--unordered", "5")
    fails(told, 2, "--window", "--unordered")


def test_a_split_that_leaves_nothing_to_learn_is_named(place, tell, tmp_path):
    alone = write(tmp_path / "alone.clips.h5", [one for one in every() if one.actor == "ann"])
    fails(
        tell("mocap-evaluate", alone, "--groups", place / "groups.toml", "--split", "leave-one-out"),
        2,
        "all clips are of 'ann'",
        "--split clips",
    )


def test_the_console_script_is_the_same_command(place, tmp_path, capsys):
    assert (
        mocap_classify([str(place / "model.h5"), str(place / "all.clips.h5"), "-o", str(tmp_path / "x.h5"), "-n"]) == 0
    )
    assert "run, since it does not exist" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
