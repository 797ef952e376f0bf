"""The name of a result always, and its figures where it is."""

from pathlib import Path

from ipcli.stages.kit.summary import of_clips, of_result, of_views
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
