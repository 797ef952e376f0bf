"""Laws of import-clips and mocap-classify: what a user may change about recordings and what must follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ipcli.cli.main import main
from ipcli.io.files import h5
from tests.fixtures.mocap_bodies import SKELETON
from tests.fixtures.mocap_clips import QUICK, every, write, write_groups

UP = {"x": [[0, 0, 1], [1, 0, 0], [0, 1, 0]], "z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]]}  # y_up_from_file


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("model")
    source, groups = write(folder / "all.clips.h5", every(repeats=1)), write_groups(folder / "groups.toml")
    words = [str(source), "--groups", str(groups), *QUICK, "--actors", "ann,bob", "-o", str(folder / "m.h5"), "--quiet"]
    assert main(["mocap-train", *words]) == 0
    return folder / "m.h5"


@pytest.fixture(scope="module")
def asked():
    return [clip for clip in every(repeats=1) if clip.actor in ("cyd", "dan")]


@pytest.fixture
def answers(model, tmp_path):
    """What mocap-classify says of clips or of a source: answer and numbers of each clip."""
    made = iter(range(100))

    def run(source, *arguments):
        output = tmp_path / "answers" / f"{next(made)}.h5"
        path = write(output.with_suffix(".clips.h5"), source) if isinstance(source, list) else source
        assert main(["mocap-classify", str(model), str(path), "-o", str(output), "--quiet", *arguments]) == 0
        found = h5.read(output, "action-recognition").arrays
        about = zip(found["answers"], found["posterior"], found["novelty"], strict=True)
        return dict(zip(map(str, found["clips"]), about, strict=True))

    return run


def assert_alike(found, expected, tolerance=1e-3):
    """The same answers, and numbers as far as float32 positions carry."""
    assert list(found) == list(expected)
    for name, (answer, posterior, novelty) in expected.items():
        assert found[name][0] == answer, name
        np.testing.assert_allclose(found[name][1], posterior, atol=tolerance)
        np.testing.assert_allclose(found[name][2], novelty, rtol=tolerance, atol=tolerance)


def changed(clip, **changes):
    return replace(clip, motion=replace(clip.motion, **changes))


def test_the_answers_are_worth_a_law(asked, answers):
    found = answers(asked)
    assert len({answer for answer, *_ in found.values()} - {"none"}) >= 2


def test_where_somebody_stands_and_faces_means_nothing(asked, answers):
    turns = Rotation.from_rotvec(np.outer(np.linspace(0.5, 6, len(asked)), [0, 1, 0])).as_matrix()
    moved = [
        changed(
            clip,
            positions=clip.motion.positions @ turn.T + (3, 0, -2),
            rotations=turn @ clip.motion.rotations,
        )
        for clip, turn in zip(asked, turns, strict=True)
    ]
    assert_alike(answers(moved), answers(asked))


def test_labels_and_people_of_what_is_asked_about_mean_nothing(asked, answers):
    blank = [replace(clip, label="", actor="") for clip in asked]
    wrong = [replace(clip, label="sneeze", actor="eve") for clip in asked]
    expected = answers(asked)
    assert_alike(answers(blank), expected, tolerance=0)
    assert_alike(answers(wrong), expected, tolerance=0)


def test_a_clip_is_answered_alone_as_among_others_and_in_any_order(asked, answers):
    expected = answers(asked)
    backwards = answers(asked[::-1])
    assert_alike({name: backwards[name] for name in expected}, expected, tolerance=1e-12)
    for clip in asked[::3]:
        assert_alike(answers([clip]), {clip.name: expected[clip.name]}, tolerance=1e-12)


def save(folder, clips, scale=1.0, axes=None):
    """The clips as NPZ files of positions, in another unit and with another axis up."""
    folder.mkdir()
    for clip in clips:
        positions = scale * clip.motion.positions @ (np.eye(3) if axes is None else np.array(axes))
        np.savez(
            folder / f"{clip.name}.npz",
            positions=positions,
            joints=SKELETON.joints,
            parents=SKELETON.parents,
            rate=clip.motion.rate,
        )
    return folder


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("mm", 0.001), ("inch", 0.0254), ("0.3048", 0.3048)])
def test_unit_and_axes_of_files_mean_nothing_once_they_are_said(asked, answers, tmp_path, unit, metres):
    expected = answers(save(tmp_path / "plain", asked))
    assert_alike(answers(save(tmp_path / unit, asked, 1 / metres), "--unit", unit), expected)
    for up, axes in UP.items():
        found = answers(save(tmp_path / f"{unit}-{up}", asked, 1 / metres, axes), "--unit", unit, "--up", up)
        assert_alike(found, expected)


def imported(source, output, *arguments):
    assert main(["import-clips", str(source), "-o", str(output), "--quiet", *arguments]) == 0
    return h5.read(output, "clips").arrays


def test_an_import_of_an_import_is_the_import(asked, tmp_path):
    once = imported(save(tmp_path / "plain", asked), tmp_path / "once.h5", "--rate", "12.5")
    twice = imported(tmp_path / "once.h5", tmp_path / "twice.h5", "--rate", "12.5")
    assert set(once) == set(twice)
    for field, array in once.items():
        np.testing.assert_array_equal(twice[field], array)


def test_what_is_said_of_files_is_said_of_their_import(asked, answers, tmp_path):
    source = save(tmp_path / "plain", asked, 100, UP["z"])
    hints = ("--unit", "cm", "--up", "z")
    imported(source, tmp_path / "in.h5", *hints)
    assert_alike(answers(tmp_path / "in.h5"), answers(source, *hints))


def test_a_rate_that_divides_the_other_may_be_reached_in_steps(asked, tmp_path):
    source = write(tmp_path / "in.h5", asked)
    direct = imported(source, tmp_path / "direct.h5", "--rate", "5")
    imported(source, tmp_path / "between.h5", "--rate", "15")
    steps = imported(tmp_path / "between.h5", tmp_path / "steps.h5", "--rate", "5")
    for field in ("positions", "frames", "rates"):
        np.testing.assert_array_equal(steps[field], direct[field])


def test_some_actions_are_those_of_all(asked, tmp_path):
    source = write(tmp_path / "in.h5", asked)
    whole = imported(source, tmp_path / "all.h5")
    some = imported(source, tmp_path / "some.h5", "--labels", "kick,bow")
    chosen = np.isin(whole["labels"], ["kick", "bow"])
    np.testing.assert_array_equal(some["clips"], whole["clips"][chosen])
    frame = np.repeat(chosen, whole["frames"])
    np.testing.assert_array_equal(some["positions"], whole["positions"][frame])
