"""Search tasks: the searcher looks for what is wanted and does not go back at once; the experiment is sound."""

import numpy as np

from experiments.gaze import room
from experiments.saliency import search_tasks
from ipcli.io.gaze import layouts
from ipcli.schema import kind, validate
from tests.fixtures import search


def looks(searcher, seconds=400.0):
    place = search_tasks.task("blue", 9, searcher=searcher)
    return place, place.attention(np.random.default_rng(0), seconds, (0.6, 1.2))[1]


def test_what_is_wanted_is_looked_at_most_and_others_now_and_then():
    place, order = looks(search_tasks.Searcher(likeness=2.0))
    wanted = np.array([name.startswith("wanted") for name in place.names])
    assert 0.7 < wanted[order].mean() < 1.0
    assert len(np.unique(order[wanted[order]])) == wanted.sum()


def test_inhibition_keeps_the_searcher_from_going_back_at_once():
    back = []
    for inhibition in (0.0, 8.0):
        _, order = looks(search_tasks.Searcher(inhibition=inhibition))
        assert (order[1:] != order[:-1]).all()
        back.append((order[2:] == order[:-2]).mean())
    assert back[1] < 0.5 * back[0]


def test_parcels_stand_apart_and_wanted_ones_have_the_hue_of_the_task():
    place = search_tasks.task("red", 3)
    off = np.linalg.norm(place.targets[:, None] - place.targets, axis=2) + 9 * np.eye(len(place.targets))
    assert off.min() > search_tasks.APART
    wanted = np.array([name.startswith("wanted") for name in place.names])
    red = place.tint[1:, 0] / place.tint[1:].sum(axis=1)
    assert red[wanted].min() > red[~wanted].max()


def test_the_experiment_is_whole_and_points_of_regard_lie_on_parcels():
    a = search.experiment()
    validate(kind("gaze-experiment"), a)
    hit = a["por/outcome"] == "hit"
    assert hit.mean() > 0.9
    places = search_tasks.task("red", 5).targets
    off = np.linalg.norm(a["por/points"][hit, None] - places, axis=2).min(axis=1)
    assert np.median(off) < 1.6 * search_tasks.PARCEL


def test_parcels_have_their_hue_in_the_files_of_a_recording_too(tmp_path):
    """JPEG, as the sample is written: red parcels once came out blue."""
    walked = room.walk(room.Course(frames=2, width=120, height=90), 3, search_tasks.task("red", 3))
    room.write_euroc(walked, tmp_path, jpeg=90)
    written = layouts.open_recording(tmp_path).load(0).colour.astype(int)
    meant = walked.recording.load(0).colour.astype(int)
    assert np.abs(written - meant).mean() < 12
    vivid = np.ptp(meant, axis=2) > 90
    assert (meant[vivid].argmax(axis=1) == written[vivid].argmax(axis=1)).mean() > 0.9
