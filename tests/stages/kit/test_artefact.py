"""An artefact is made when it has to be, only then, and never in place of another unasked."""

import json
import logging
import os
import signal
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest

from ipcli.errors import OutputExists
from ipcli.io.files import atomic, h5
from ipcli.params import Run, option
from ipcli.stages.kit.artefact import Job, Outcome, make


@dataclass(frozen=True)
class Params:
    size: int = option(3, "Size.")


class Maker:
    """A job whose build is counted."""

    def __init__(self, folder):
        self.folder, self.built = folder, 0
        self.output = folder / "out" / "a.views.h5"
        self.side = folder / "out" / "a.txt"
        (folder / "input.txt").write_text("input")

    def __call__(self, size=3, **run):
        job = Job(
            self.output, "views", "test", Params(size), (self.folder / "input.txt",), {self.side: self.write_side}
        )
        return make(job, lambda: self.build(size), Run(**run))

    def build(self, size):
        self.built += 1
        return {
            "views/0/depth": np.full((size, size), 2.0, np.float32),
            "views/0/intrinsics": np.eye(3),
            "views/0/cam_from_world": np.eye(4),
            "unit": np.array("m"),
            "measured": np.array("depth"),
        }

    def write_side(self, path, arrays, provenance):
        atomic.write_text(path, f"{arrays['views/0/depth'].sum()} {provenance['digest']}")

    def bytes(self):
        return self.output.read_bytes(), self.side.read_bytes()


@pytest.fixture
def maker(tmp_path):
    return Maker(tmp_path)


def test_a_second_run_is_up_to_date_and_touches_nothing(maker):
    assert maker() is Outcome.DONE
    stamps = [path.stat().st_mtime_ns for path in sorted(maker.output.parent.iterdir())]
    assert maker() is Outcome.UP_TO_DATE
    assert maker.built == 1
    assert [path.stat().st_mtime_ns for path in sorted(maker.output.parent.iterdir())] == stamps


def test_the_artefact_says_how_it_was_made_and_what_varies_lies_beside(maker):
    maker(seed=4)
    record = h5.read(maker.output, "views").provenance
    assert (record["command"], record["params"], record["seed"]) == ("test", {"size": 3}, 4)
    assert maker.side.read_text() == f"18.0 {record['digest']}"
    varies = json.loads((maker.output.parent / "a.views.run.json").read_text())
    assert varies["elapsed_s"] >= 0
    assert sorted(path.name for path in maker.output.parent.iterdir()) == ["a.txt", "a.views.h5", "a.views.run.json"]


def test_two_runs_in_two_folders_give_the_same_bytes(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    makers = [Maker(tmp_path / "one"), Maker(tmp_path / "two")]
    for maker in makers:
        maker()
    assert makers[0].bytes() == makers[1].bytes()


@pytest.mark.parametrize("change", ["params", "seed", "input"])
def test_any_other_result_is_refused_until_overwrite(maker, change):
    maker()
    before = maker.bytes()
    if change == "input":
        (maker.folder / "input.txt").write_text("other")
    other = {"params": {"size": 5}, "seed": {"seed": 1}, "input": {}}[change]
    for run in ({}, {"dry_run": True}):
        with pytest.raises(OutputExists, match=r"a\.views\.h5: exists and was made with other .* Give --overwrite"):
            maker(**other, **run)
    assert (maker.built, maker.bytes()) == (1, before)
    assert maker(**other, overwrite=True) is Outcome.DONE
    assert maker.bytes() != before
    assert maker(**other) is Outcome.UP_TO_DATE


def test_overwrite_makes_even_the_same_anew(maker):
    maker()
    assert maker(overwrite=True) is Outcome.DONE
    assert maker.built == 2


def test_a_missing_side_file_is_made_again_with_the_same_bytes(maker):
    maker()
    before = maker.bytes()
    maker.side.unlink()
    assert maker(dry_run=True) is Outcome.WOULD_RUN
    assert not maker.side.exists()
    assert maker() is Outcome.DONE
    assert maker.bytes() == before


def test_a_dry_run_tells_why_and_touches_nothing(maker, caplog):
    with caplog.at_level(logging.WARNING, "ipcli"):
        assert maker(dry_run=True) is Outcome.WOULD_RUN
    assert "a.views.h5: run, since it does not exist" in caplog.text
    assert maker.built == 0
    assert not maker.output.parent.exists()


@pytest.mark.parametrize("content", [b"", b"not ours", "cut"])
def test_a_file_that_is_not_a_sound_artefact_is_refused(maker, content):
    if content == "cut":
        maker()
        content = maker.output.read_bytes()[:1000]
    atomic.write_bytes(maker.output, content)
    with pytest.raises(OutputExists, match="is not a sound artefact of ipcli"):
        maker()
    assert maker.output.read_bytes() == content


def test_an_artefact_of_another_kind_is_refused(maker):
    maker()
    with pytest.raises(OutputExists, match="is of kind 'views', not 'depth'"):
        make(Job(maker.output, "fused-depth", "test", Params(), ()), dict, Run())


def test_a_failure_anywhere_publishes_nothing(maker):
    maker()
    before = maker.bytes()

    def fail(path, arrays, provenance):
        raise RuntimeError("no space")

    first, second = maker.side, maker.output.parent / "b.txt"
    job = Job(maker.output, "views", "test", Params(4), (), {first: maker.write_side, second: fail})
    with pytest.raises(RuntimeError, match="no space"):
        make(job, lambda: maker.build(4), Run(overwrite=True))
    assert maker.bytes() == before
    assert sorted(path.name for path in maker.output.parent.iterdir()) == ["a.txt", "a.views.h5", "a.views.run.json"]


KILLED = """
import os, signal, sys
from pathlib import Path
from ipcli.io import atomic
from tests.stages.kit.test_artefact import Maker
maker = Maker(Path(sys.argv[1]))
steps, at = [0], int(sys.argv[2])
def step(event, arguments):
    if event in ("os.rename", "open") and str(maker.output.parent) in str(arguments[0]):
        steps[0] += 1
        if steps[0] == at:
            os.kill(os.getpid(), signal.SIGKILL)
sys.addaudithook(step)
maker(size=4, overwrite=True)
"""


def test_killed_at_any_step_the_next_run_ends_as_if_undisturbed(tmp_path):
    (tmp_path / "calm").mkdir()
    calm = Maker(tmp_path / "calm")
    calm(size=4)
    env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    outcomes = []
    for at in (1, 3, 5, 6, 7, 8):
        (tmp_path / str(at)).mkdir()
        maker = Maker(tmp_path / str(at))
        maker(size=3)
        old = maker.bytes()
        killed = subprocess.run(
            [sys.executable, "-c", KILLED, str(maker.folder), str(at)], env=env, capture_output=True
        )
        assert killed.returncode in (0, -signal.SIGKILL), killed.stderr
        assert maker.output.read_bytes() in (old[0], calm.bytes()[0])
        maker(size=4, overwrite=True)
        assert maker.bytes() == calm.bytes()
        outcomes.append(killed.returncode)
    assert outcomes.count(-signal.SIGKILL) >= 4
