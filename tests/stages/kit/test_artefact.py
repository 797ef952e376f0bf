"""An artefact is made when it has to be, only then, and never in place of another unasked."""

import json
import logging

import pytest

from ipcli.errors import OutputExists, OutputRefused
from ipcli.io.files import atomic, h5
from ipcli.params import Run
from ipcli.stages.kit.artefact import Job, Outcome, make
from tests.fixtures.maker import Maker, Size


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
    for run in ({}, {"overwrite": True}, {"dry_run": True}):
        with pytest.raises(OutputRefused, match="is not a sound artefact of ipcli"):
            maker(**run)
    assert maker.output.read_bytes() == content


def test_an_artefact_of_another_kind_is_refused(maker):
    maker()
    for overwrite in (False, True):
        with pytest.raises(OutputRefused, match="is of kind 'views', not 'fused-depth'"):
            make(Job(maker.output, "fused-depth", "test", Size(), ()), dict, Run(overwrite=overwrite))


def test_a_failure_anywhere_publishes_nothing(maker):
    maker()
    before = maker.bytes()

    def fail(path, arrays, provenance):
        raise RuntimeError("no space")

    first, second = maker.side, maker.output.parent / "b.txt"
    job = Job(maker.output, "views", "test", Size(4), (), {first: maker.write_side, second: fail})
    with pytest.raises(RuntimeError, match="no space"):
        make(job, lambda: maker.build(4), Run(overwrite=True))
    assert maker.bytes() == before
    assert sorted(path.name for path in maker.output.parent.iterdir()) == ["a.txt", "a.views.h5", "a.views.run.json"]


def test_what_is_written_beside_cannot_draw_into_the_artefact(maker):
    """Side files are written at the same time: a page that marks a picture in place spoiled the picture's checksum."""

    def marks(path, arrays, provenance):
        arrays["views/0/depth"][0] = 7.0

    maker.write_side = marks
    with pytest.raises(ValueError, match="read-only"):
        maker()
    assert not maker.output.exists()
