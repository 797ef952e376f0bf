"""What the defaults rest on: rows hold what a fusion at each value gives, and shipped values are among those tried."""

from pathlib import Path

import pytest

from experiments.fusion import choices
from experiments.kit.arguments import Arguments
from ipcli.models.fusion.fuse import fuse, fuse_unfilled
from ipcli.models.fusion.scenes import EstimatedMap
from ipcli.params import find_config, resolve
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import open_scene
from tests.fixtures.fusion_scenes import scene, write


@pytest.mark.parametrize("name", choices.CHOICES)
def test_what_is_shipped_is_among_what_was_tried(name):
    choice = choices.CHOICES[name]
    shipped = resolve(FuseDepth, config=choice.config and find_config(Path(choice.config), "fuse-depth"))
    for key, values in choice.tried.items():
        assert choices._value(shipped, key) in values, key


def test_a_row_is_what_a_fusion_at_that_value_gives(tmp_path):
    path = write(tmp_path / "a.views.h5", scene(seed=3, shape=(40, 50)))
    found = choices.make(Arguments("defaults", tmp_path / "index.html", (path,), quick=True))
    assert len(found.rows) == choices.QUICK * len(choices.CHOICES["defaults"].tried)
    assert sum(row["shipped"] for row in found.rows) == len(choices.CHOICES["defaults"].tried)
    row = next(row for row in found.rows if row["setting"] == "fusion.edges.gain" and not row["shipped"])
    params = resolve(FuseDepth, sets=[*choices.ROUGHLY, f"fusion.edges.gain={row['value']}"])
    scene_of = open_scene(path, None, "auto")
    fused = fuse(scene_of.views, scene_of.reference, params.fusion, inverse=scene_of.inverse)
    columns, figures = scene_of.errors({"fused": EstimatedMap.of(fused)})
    assert row["RMSE"] == pytest.approx(figures[0][columns.index("RMSE")])
    shipped = next(row for row in found.rows if row["shipped"])
    assert row["RMSE better"] == (row["RMSE"] < shipped["RMSE"])
    assert "(shipped)" in found.page


def test_each_fusion_is_made_once_and_the_reach_of_holes_needs_none(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(choices, "fuse_unfilled", lambda *a, **k: made.append(a[2]) or fuse_unfilled(*a, **k))
    one = open_scene(write(tmp_path / "a.views.h5", scene(seed=3, shape=(40, 50))), None, "auto")
    reached = [resolve(FuseDepth, sets=["fusion.solver.iterations=5", f"fusion.holes.reach={r}"]) for r in (1, 100, 1)]
    found = choices.measures_of(one, reached, ("RMSE",))
    assert len(made) == 1
    assert len(found) == 2
