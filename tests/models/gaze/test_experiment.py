"""The whole of gaze-sfm on generated rooms: path, points of regard with honest regions, keyframes, losses, offsets."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from experiments.gaze import room
from ipcli.errors import NoSolution
from ipcli.models.gaze import adjustment, checks, evaluation, localise
from ipcli.models.gaze.experiment import experiment
from ipcli.models.gaze.parameters import Detection, Localisation, Looking
from tests.fixtures.gaze_walks import walk

SMALL = room.Course(frames=30, width=320, height=240, rate=12.0, gaze_rate=60.0)
SETTINGS = Localisation(looking=Looking(sigma=2**-0.5), detection=Detection(count=800))


@cache
def run(seed=5, **changes):
    course = room.Course(**{**SMALL.__dict__, **changes})
    walked = walk(course, seed)
    return walked, experiment(walked.recording, SETTINGS, 0)


def test_the_path_is_right_to_millimetres():
    walked, a = run()
    assert not a["lost"].any()
    errors = evaluation.path_errors(a["world_from_rig"], walked.recording.truth)
    assert errors.rigid.rmse < 0.01
    assert errors.similar.scale == pytest.approx(1, abs=0.02)


def test_points_of_regard_lie_on_the_targets_and_their_regions_are_honest():
    walked, a = run()
    moved = evaluation.registration(a["world_from_rig"], walked.recording.truth)
    places = room.TARGETS[walked.looked_at]
    errors, squares = evaluation.target_errors(a["por/points"], a["por/covariance"], places, moved)
    assert np.isfinite(errors).mean() > 0.9
    assert np.sqrt(np.nanmean(errors**2)) < 0.13  # half the resolution of the experiment: .094 there
    inside = evaluation.coverage(squares)
    assert 0.55 < inside[0.68] < 0.85
    assert inside[0.95] > 0.88


def test_keyframes_are_where_attention_turns():
    walked, a = run()
    scores = evaluation.keyframe_scores(np.flatnonzero(a["keyframe"]), walked.keyframes, 3)
    assert scores["f1"] > 0.8
    assert (np.diff(a["subsequences/frames"][:, 0]) > 0).all()


def test_the_same_seed_gives_the_same_arrays():
    _, a = run()
    walked = walk(SMALL, 5)  # all pictures anew
    b = experiment(walked.recording, SETTINGS, 0)
    assert all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in a)


def test_dark_frames_are_lost_and_found_again_in_the_same_map():
    walked, a = run(dark=(12, 18))
    assert a["lost"][12:18].all()
    assert not a["lost"][20:].any()
    assert np.isnan(a["world_from_rig"][12:18]).all()
    assert "dark" in str(a["reasons"][12])
    assert (a["por/outcome"][np.isin(a["por/frame"], range(12, 18))] == "lost").all()
    errors = evaluation.path_errors(a["world_from_rig"], walked.recording.truth)
    assert errors.rigid.rmse < 0.01  # one map, not two: the frames after the dark lie in the frame of those before


def test_nobody_who_stands_still_makes_a_keyframe_or_drifts():
    _, a = run(still=True, frames=20, dwell=(30.0, 40.0))
    assert a["keyframe"].sum() == 1  # the first
    path = a["world_from_rig"][:, :3, 3]
    assert np.linalg.norm(path - path[0], axis=1).max() < 0.005


def test_all_dark_has_no_solution():
    walked = room.walk(room.Course(**{**SMALL.__dict__, "frames": 4, "dark": (0, 4)}), 1)
    with pytest.raises(NoSolution, match="no frame could be localised"):
        experiment(walked.recording, SETTINGS, 0)


def test_an_offset_of_the_right_camera_is_found():
    walked = walk(room.Course(**{**SMALL.__dict__, "offset": 0.5}), 5)
    path = localise.localise(walked.recording, Localisation(self_calibrate="on"), 0)
    assert path.rig.offset == pytest.approx(0.5, abs=0.12)


def test_an_offset_counts_only_when_the_blocks_agree():
    agree = adjustment.Offset(0.23, np.array([0.2, 0.25, 0.22, 0.24]))
    assert agree.is_certain
    assert not adjustment.Offset(0.03, np.array([-0.02, 0.06, -0.1, 0.06])).is_certain
    assert not adjustment.Offset(0.2, np.array([0.2, np.nan, np.nan, np.nan])).is_certain


def test_check_tells_exchanged_cameras():
    walked, _ = run()
    good = checks.verdict(walked.recording, checks.pairs(walked.recording, SETTINGS, 3))[1]
    assert not [word for word in good if "exchanged" in word or "calibration" in word]

    def swapped(k):
        frame = walked.recording.load(k)
        return replace(frame, left=frame.right, right=frame.left)

    wrong = replace(walked.recording, load=swapped)
    warnings = checks.verdict(wrong, checks.pairs(wrong, SETTINGS, 3))[1]
    assert any("exchanged" in word for word in warnings)


def test_keyframe_scores_punish_too_many():
    scores = evaluation.keyframe_scores(np.array([0, 1, 2, 10, 30]), np.array([0, 11, 50]), 2)
    assert scores["agreement"] == pytest.approx(2 / 3)
    assert scores["precision"] == pytest.approx(2 / 5)
    assert scores["f1"] == pytest.approx(4 / 8)
