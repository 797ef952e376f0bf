"""Nothing is lost: no run replaces an input, nor a file that it did not make itself under that very name."""

import errno
import json
import os
import signal
import sys

import numpy as np
import pytest

from ipcli.errors import IpcliError, OutputExists, OutputRefused, ParameterError
from ipcli.io.files import atomic, h5
from ipcli.params import Run
from ipcli.stages.kit import outputs
from ipcli.stages.kit.artefact import Job, Outcome, make
from tests.fixtures.errors import check_message
from tests.fixtures.maker import Maker, Size

EITHER = pytest.mark.parametrize("overwrite", [False, True], ids=["", "--overwrite"])


@pytest.fixture
def maker(tmp_path):
    return Maker(tmp_path)


def listed(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@EITHER
@pytest.mark.parametrize("how", ["itself", "link", "hard link", "dots"])
def test_an_input_is_never_written_to_under_any_name(maker, how, overwrite):
    maker()
    source = maker.output
    path = {
        "itself": source,
        "link": source.with_name("l.h5"),
        "hard link": source.with_name("h.h5"),
        "dots": source.parent / ".." / "out" / source.name,
    }[how]
    if how == "link":
        path.symlink_to(source)
    if how == "hard link":
        os.link(source, path)
    before = listed(source.parent)
    with pytest.raises(OutputRefused, match="is an input of this run"):
        make(Job(path, "views", "test", Size(), (source,)), dict, Run(overwrite=overwrite))
    side = {path: maker.write_side}
    with pytest.raises(OutputRefused, match="is an input of this run"):
        make(Job(source.with_name("new.h5"), "views", "test", Size(), (source,), side), dict, Run(overwrite=overwrite))
    assert listed(source.parent) == before


@EITHER
def test_nothing_is_written_into_an_input_folder(maker, overwrite):
    folder = maker.folder / "in" / "deeper"
    folder.mkdir(parents=True)
    job = Job(folder / "x.h5", "views", "test", Size(), (maker.folder / "in",))
    with pytest.raises(OutputRefused, match="lies in the input folder"):
        make(job, dict, Run(overwrite=overwrite))
    assert list(folder.iterdir()) == []


@EITHER
def test_side_files_of_one_suffix_are_told_apart(maker, overwrite):
    """Both `a.txt` and `a.more.txt` are of this run; one in place of the other is not."""
    more = maker.output.parent / "a.more.txt"
    sides = {maker.side: maker.write_side, more: lambda path, arrays, provenance: path.write_text("more")}
    job = Job(maker.output, "views", "test", Size(), (maker.source,), sides)
    assert make(job, lambda: maker.build(3), Run()) is Outcome.DONE
    assert make(job, dict, Run()) is Outcome.UP_TO_DATE
    more.write_bytes(maker.side.read_bytes())
    with pytest.raises(OutputRefused, match="a.more.txt"):
        make(job, dict, Run(overwrite=overwrite))


@EITHER
@pytest.mark.parametrize("name", ["a.txt", "a.views.run.json"])
@pytest.mark.parametrize("when", ["before the artefact", "beside the artefact"])
def test_a_foreign_side_file_is_refused_before_any_work(maker, name, when, overwrite):
    if when == "beside the artefact":
        maker()
    path = maker.output.parent / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("{}")
    before, built = listed(path.parent), maker.built
    with pytest.raises(OutputRefused, match=f"{name}: exists and is not what ipcli wrote there with a.views.h5"):
        maker(overwrite=overwrite)
    assert (listed(path.parent), maker.built) == (before, built)


def test_an_artefact_that_was_written_under_another_name_is_not_replaced(maker):
    maker()
    other = maker.output.rename(maker.output.with_name("b.views.h5"))
    before = other.read_bytes()
    for size, overwrite in ((3, True), (4, True), (4, False)):
        job = Job(other, "views", "test", Size(size), (maker.source,))
        with pytest.raises((OutputRefused, OutputExists), match=r"no b\.views\.run\.json|made with other parameters"):
            make(job, lambda: maker.build(3), Run(overwrite=overwrite))
    assert other.read_bytes() == before


def test_the_same_work_gives_the_same_bytes_under_any_name_and_needs_its_record_to_be_replaced(maker):
    maker()
    there = maker.folder / "there"
    there.mkdir()
    output, side = there / "c.views.h5", there / "c.views.txt"
    job = Job(output, "views", "test", Size(), (maker.source,), {side: maker.write_side})
    make(job, lambda: maker.build(3), Run())
    assert (output.read_bytes(), side.read_bytes()) == maker.bytes()
    (there / "c.views.run.json").unlink()
    with pytest.raises(OutputRefused, match="c.views.txt: exists and is not what ipcli wrote"):
        make(job, dict, Run())
    side.unlink()
    for overwrite in (False, True):
        with pytest.raises(OutputRefused, match="no c.views.run.json beside it"):
            make(job, dict, Run(overwrite=overwrite))
    alone = Job(output, "views", "test", Size(), (maker.source,))
    assert make(alone, dict, Run()) is Outcome.UP_TO_DATE


@pytest.mark.parametrize("part", [0.0, 0.5, 0.999])
def test_a_side_file_that_was_cut_or_changed_is_neither_up_to_date_nor_replaced(maker, part):
    maker()
    data = maker.side.read_bytes()
    maker.side.write_bytes(data[: int(part * len(data))])
    for overwrite in (False, True):
        with pytest.raises(OutputRefused, match=r"a\.txt: exists and is not what ipcli wrote"):
            maker(overwrite=overwrite)
    maker.side.unlink()
    assert maker() is Outcome.DONE
    assert maker.side.read_bytes() == data


def test_a_flipped_byte_anywhere_is_not_up_to_date(maker):
    maker(size=8)
    data = maker.output.read_bytes()
    for at in np.linspace(0, len(data) - 1, 40).astype(int):
        maker.output.write_bytes(data[:at] + bytes([data[at] ^ 16]) + data[at + 1 :])
        try:
            outcome = maker(size=8)
        except IpcliError as error:
            check_message(error, maker.output.name)
        else:  # a byte that means nothing
            assert outcome is Outcome.UP_TO_DATE
            assert _same(h5.read(maker.output, "views").arrays, maker.build(8))
    assert maker.output.write_bytes(data)


def _same(found, expected):
    return found.keys() == expected.keys() and all(np.array_equal(found[name], expected[name]) for name in found)


@pytest.mark.parametrize("name", ["run.1", "mesh.ply", "page.html", "none", "x.H5.gz"])
def test_a_name_that_is_no_artefact_s_is_refused_before_any_work(tmp_path, name):
    with pytest.raises(ParameterError, match=r"results are written as X\.h5"):
        make(Job(tmp_path / name, "views", "test", Size(), ()), dict, Run())
    assert list(tmp_path.iterdir()) == []


def test_folders_pipes_and_standard_output_are_no_places_for_a_file(tmp_path):
    (tmp_path / "folder.h5").mkdir()
    os.mkfifo(tmp_path / "pipe.h5")
    (tmp_path / "file").write_text("")
    places = {"folder.h5": "is a folder", "pipe.h5": "is no plain file", "file/x.h5": "is no folder"}
    for name, why in places.items():
        with pytest.raises(ParameterError, match=why):
            make(Job(tmp_path / name, "views", "test", Size(), ()), dict, Run(overwrite=True))
    with pytest.raises(ParameterError, match="standard output"):
        outputs.check_place(tmp_path / "-")
    with pytest.raises(ParameterError, match="is a file, but the results go into a folder"):
        outputs.check_place(tmp_path / "file", folder=True)


def test_a_folder_that_cannot_be_written_to_is_refused_before_any_work(tmp_path, monkeypatch):
    asked = []

    def refuse(dir):
        asked.append(dir)
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    def work():
        raise AssertionError("the work was begun")

    monkeypatch.setattr(outputs.tempfile, "TemporaryFile", refuse)
    with pytest.raises(ParameterError, match="cannot be written to .Read-only file system"):
        make(Job(tmp_path / "new" / "x.h5", "views", "test", Size(), ()), work, Run())
    assert asked == [tmp_path]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("overwrite", [False, True], ids=["same", "other parameters"])
def test_of_two_runs_at_once_the_later_does_not_replace_the_result_of_the_earlier(maker, overwrite):
    def meanwhile(size):
        Maker(maker.folder)(size=4)
        return maker.build(size)

    with pytest.raises(OutputExists, match="written by another run while this one was at work"):
        maker(size=5, build=meanwhile)
    assert h5.read(maker.output, "views").provenance["params"] == {"size": 4}
    assert maker(size=4) is Outcome.UP_TO_DATE


def test_two_runs_of_the_same_at_once_both_end_well(maker):
    def meanwhile(size):
        Maker(maker.folder)(size=size)
        return maker.build(size)

    assert maker(build=meanwhile) is Outcome.DONE
    assert maker() is Outcome.UP_TO_DATE


def test_a_file_that_appears_while_names_are_given_is_kept(maker, monkeypatch):
    publish = atomic.publish

    def late(draft, path, **how):
        if path == maker.side:
            path.write_text("somebody else's")
        publish(draft, path, **how)

    monkeypatch.setattr(atomic, "publish", late)
    with pytest.raises(OutputExists, match="written by another run"):
        maker()
    assert maker.side.read_text() == "somebody else's"


@pytest.mark.parametrize("kind", ["file", "file in a folder", "new file in a folder"])
def test_an_input_that_changes_while_it_is_read_is_no_result(maker, kind):
    folder = maker.folder / "data"
    folder.mkdir()
    (folder / "a").write_text("old")
    changed = folder / ("b" if kind == "new file in a folder" else "a")

    def build():
        changed.write_text("new")
        return maker.build(3)

    source = folder / "a" if kind == "file" else folder
    with pytest.raises(IpcliError, match="changed while it was read; nothing was written"):
        make(Job(maker.output, "views", "test", Size(), (source,)), build, Run())
    assert not maker.output.exists()


def test_an_input_that_is_only_touched_is_the_same(maker):
    def build(size):
        os.utime(maker.source)
        return maker.build(size)

    assert maker(build=build) is Outcome.DONE


def killed(maker, at):
    """Overwrite in a child that is killed at this step; its status, 0 if there were not so many steps."""
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1]
    steps = 0

    def step(event, arguments):
        nonlocal steps
        if event in ("os.rename", "os.link", "os.remove", "open") and str(maker.output.parent) in str(arguments[0]):
            steps += 1
            if steps == at:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(step)
    maker(size=4, overwrite=True)
    os._exit(0)


@pytest.mark.skipif(os.name == "nt", reason="needs fork and SIGKILL")
def test_an_overwrite_killed_at_any_step_never_passes_for_the_old_result_nor_locks_out_the_new(tmp_path):
    (tmp_path / "calm").mkdir()
    calm = Maker(tmp_path / "calm")
    calm(size=4)
    at, status = 0, signal.SIGKILL
    while status:
        at += 1
        (tmp_path / str(at)).mkdir()
        maker = Maker(tmp_path / str(at))
        maker(size=3)
        old = maker.bytes()
        status = killed(maker, at)
        assert status in (0, signal.SIGKILL)
        try:  # the old command never calls a mixture up to date
            if maker(size=3) is Outcome.UP_TO_DATE:
                assert maker.bytes() == old
        except OutputExists:
            assert h5.read(maker.output, "views").provenance["params"] == {"size": 4}
        maker(size=4, overwrite=True)
        assert maker.bytes() == calm.bytes()
        assert sorted(listed(maker.output.parent)) == sorted(listed(calm.output.parent)) or strays(maker)
    assert at > 15


def strays(maker):
    """What a kill leaves is swept when it is a day old."""
    left = listed(maker.output.parent).keys() - {"a.views.h5", "a.txt", "a.views.run.json"}
    return all(atomic.ORPHAN.fullmatch(name) for name in left)


def test_a_journal_that_is_no_journal_vouches_for_nothing(maker):
    for text in ("[]", "{", json.dumps({"files": {"a.txt": ["0" * 64]}}), '{"files": [1]}', "[" * 100_000):
        maker.output.parent.mkdir(exist_ok=True)
        outputs.journal_path(maker.output).write_text(text)
        maker.side.write_text("somebody else's")
        with pytest.raises(OutputRefused):
            maker()
        assert maker.side.read_text() == "somebody else's"
