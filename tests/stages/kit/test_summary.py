"""The name of a result always, and its figures where it is."""

from pathlib import Path

import numpy as np

from ipcli.io.files import h5
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.kit.summary import of_clips, of_items, of_recording, of_result, of_views
from tests.fixtures import fusion_scenes, mocap_clips
from tests.fixtures.mocap_bodies import ACTIONS


@of_result
def summary(output: Path) -> dict[str, int]:
    """How many letters it has."""
    return {"letters": len(output.read_text())}


def test_figures_come_after_the_name_of_what_is_there(tmp_path):
    (tmp_path / "a.txt").write_text("abc")
    assert summary(tmp_path / "a.txt") == {"output": tmp_path / "a.txt", "letters": 3}
    assert next(iter(summary(tmp_path / "a.txt"))) == "output"
    assert summary.__doc__ == "How many letters it has."


def test_of_what_is_not_there_only_the_name_is_told(tmp_path):
    assert summary(tmp_path / "none.txt") == {"output": tmp_path / "none.txt"}


def test_views_and_clips_are_counted(tmp_path):
    path = fusion_scenes.write(tmp_path / "a.views.h5", fusion_scenes.scene(k=3, shape=(12, 16)))
    assert of_views(path) == {"output": path, "views": 3, "measured": "depth", "unit": "m"}
    clips = mocap_clips.write(tmp_path / "a.clips.h5", [mocap_clips.clip(action, 0) for action in list(ACTIONS)[:2]])
    told = of_clips(clips)
    assert (told["clips"], told["actions"]) == (2, 2)
    assert told["frames"] > 2


def test_the_files_of_a_folder_are_counted_by_how_they_came_about(tmp_path):
    ends = {tmp_path / "a.h5": Outcome.DONE, tmp_path / "b.h5": Outcome.UP_TO_DATE, tmp_path / "c.h5": Outcome.DONE}
    told = of_items(tmp_path, ends)
    assert told["output"] == tmp_path
    assert str(told["outputs"]) == "2 done, 1 up to date"
    assert told["outputs"].value[str(tmp_path / "b.h5")] == "up to date"
    assert str(of_items(tmp_path, {})["outputs"]) == "none"


def test_a_recording_is_told_by_its_length_and_what_it_holds(tmp_path, monkeypatch):
    (tmp_path / "a.h5").write_bytes(b"")
    held = h5.Artefact("recording", 1, {"times": np.array([2.0, 2.5, 14.25])}, {})
    monkeypatch.setattr(h5, "read", lambda *given: held)
    monkeypatch.setattr(h5, "names", lambda path: ("frames/0/depth", "frames/0/left", "gaze/times", "times"))
    told = of_recording(tmp_path / "a.h5")
    assert (told["frames"], str(told["length"]), told["length"].value) == (3, "12.25 s", 12.25)
    assert str(told["holds"]) == "pictures, gaze, depth"
