"""Whether a fusion fits is decided and said before it starts."""

import logging

import numpy as np
import pytest

from ipcli import memory
from ipcli.errors import IpcliError
from ipcli.inverse.regularize.parameters import Solver
from ipcli.io.files import h5
from ipcli.io.views import artefact
from ipcli.models.fusion import footprint
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import fuse_depth
from ipcli.stages.fusion.memory_plan import MemoryPlan
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.kit.artefact import Outcome
from tests.fixtures.fusion_scenes import scene, write

SHAPE = (160, 208)
QUICK = Fusion(solver=Solver(iterations=40), rounds=1)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "scene.views.h5", scene(3, SHAPE))


@pytest.fixture(autouse=True)
def tight(monkeypatch):
    """So tight that the small scene fits in tiles of 64 alone: the process counts for nothing."""
    for name in ("PROCESS", "PUBLISHING"):
        monkeypatch.setattr(footprint, name, 90_000_000)
    monkeypatch.setattr(footprint, "PICTURED", 0)
    monkeypatch.setattr(footprint, "MARGIN", 8)
    monkeypatch.setattr(footprint, "SIDE", 128)
    monkeypatch.setattr(footprint, "SIDES", (64,))
    monkeypatch.setattr("ipcli.models.fusion.tiles.MARGIN", 8)
    monkeypatch.setenv(memory.VARIABLE, "94MB")


def run(source, output, fusion=QUICK, **how):
    return fuse_depth.run(source, output, FuseDepth(fusion=fusion), Run(**how))


def test_a_dry_run_says_what_it_takes_and_why_it_goes_in_tiles(source, tmp_path, caplog):
    assert run(source, tmp_path / "x.fused.h5", dry_run=True) is Outcome.WOULD_RUN
    (said,) = [record.getMessage() for record in caplog.records if "Mpx" in record.getMessage()]
    assert "0.0333 Mpx of 3 views, in tiles of 64 px: about 9" in said
    assert "MB of the 94 MB of --max-memory, since it would take 100 MB at once" in said


def test_the_limit_is_no_parameter_and_the_artefact_says_in_which_tiles_it_was_made(
    source, tmp_path, monkeypatch, caplog
):
    run(source, tmp_path / "x.fused.h5")
    made = h5.read(tmp_path / "x.fused.h5", "fused-depth")
    assert made.arrays["tile"] == 64
    assert made.provenance["params"]["fusion"]["tile"] is None
    assert [record.levelno for record in caplog.records if "in tiles" in record.getMessage()] == [logging.WARNING]
    monkeypatch.setenv(memory.VARIABLE, "50%")
    assert run(source, tmp_path / "x.fused.h5") is Outcome.UP_TO_DATE
    asked = Fusion(solver=Solver(iterations=40), rounds=1, tile=64)
    run(source, tmp_path / "asked.fused.h5", asked)
    same = h5.read(tmp_path / "asked.fused.h5", "fused-depth")
    np.testing.assert_array_equal(made.arrays["depth"], same.arrays["depth"])
    run(source, tmp_path / "whole.fused.h5")
    whole = h5.read(tmp_path / "whole.fused.h5", "fused-depth")
    assert "tile" not in whole.arrays
    apart = np.abs(made.arrays["depth"] - whole.arrays["depth"])
    assert np.median(apart) < 0.1 * whole.arrays["noise_scale"]  # the tolerance that docs/fuse-depth.md states


def test_a_view_is_read_from_its_source_once(source, tmp_path, monkeypatch):
    asked, load = [], artefact.check_view
    monkeypatch.setattr(artefact, "check_view", lambda view, path: asked.append(view.name) or load(view, path))
    run(source, tmp_path / "x.fused.h5")
    assert sorted(asked) == sorted(set(asked))
    assert len(asked) == 3
    assert {path.suffix for path in tmp_path.iterdir()} == {".h5", ".ply", ".html", ".json"}


def test_what_fits_in_no_way_is_refused_in_one_line_before_the_work(source, tmp_path, monkeypatch):
    monkeypatch.setenv(memory.VARIABLE, "91MB")
    with pytest.raises(
        IpcliError, match=r"in the smallest tiles 9.*--max-memory is 91 MB. Raise it, or give a smaller --camera"
    ):
        run(source, tmp_path / "x.fused.h5")
    with pytest.raises(IpcliError, match="leave out fusion.tile"):
        run(source, tmp_path / "x.fused.h5", Fusion(tile=0), dry_run=True)
    assert not list(tmp_path.iterdir())


def test_the_number_of_threads_has_no_say(monkeypatch):
    view = scene(1, SHAPE)[0]
    plans = []
    for count in ("1", "7"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", count)
        plans.append(MemoryPlan.of(view, 3, QUICK))
    assert plans[0] == plans[1]
