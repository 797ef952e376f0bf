"""Every command that writes: what it must not write to is refused before any work, with and without --overwrite.

What the commands share is tested closer by in tests/stages/kit/test_outputs.py; here, that all of them do share it.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import click
import pytest

from ipcli.cli import main as cli
from tests.fixtures import mocap_clips
from tests.fixtures.commands import CASES, fused, line

OWN = {"report"}  # its page is no artefact: tests/stages/kit/test_report.py
MODULE_SCOPE = "module"


@pytest.fixture(params=CASES)
def command(request):
    return request.param


@pytest.fixture(scope=MODULE_SCOPE)
def made(tmp_path_factory):
    """The inputs of each command, made once."""
    cache = {}

    def make(name):
        if name not in cache:
            folder = tmp_path_factory.mktemp(name.replace(" ", ""))
            cache[name] = CASES[name](folder)
        return cache[name]

    return make


@pytest.fixture
def case(command, made):
    return made(command)


@pytest.fixture(params=[(), ("--overwrite",)], ids=["", "--overwrite"])
def options(request):
    return request.param


def refused(name, case, output, options, capsys):
    """Run the command, which must fail with one line and leave every file as it was, and make none; that line.

    A command that fills a folder may make the files that nothing speaks against.
    """
    places = {output.parent, *(path.parent for path in case.inputs)}
    before = contents(places)
    assert cli.main(line(name, case, output, ["--quiet", *options])) in (1, 2)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("Error: ")
    assert err.count("\n") == 1
    after = contents(places)
    assert {path: after.get(path) for path in before} == before
    assert case.into_folder or after == before
    return err


def contents(folders):
    files = (path for folder in folders if folder.is_dir() for path in sorted(folder.rglob("*")))
    return {path: path.read_bytes() if path.is_file() else None for path in files}


def test_every_command_that_writes_is_tested_here():
    writing = {
        name
        for name in cli.COMMANDS
        if any(isinstance(option, click.Option) and "--output" in option.opts for option in cli.load(name).params)
    }
    assert {name.split()[0] for name in CASES} | OWN == writing


def target(command, case, output):
    """The output that makes the command write `output`."""
    return output.parent if case.into_folder else output


def test_an_input_is_never_the_output(command, case, options, capsys):
    for path in case.inputs:
        if not case.into_folder:
            assert path.name in refused(command, case, path, options, capsys)


def test_the_name_of_an_input_in_the_output_folder_is_no_output_either(command, case, options, capsys, tmp_path):
    if not case.into_folder:
        pytest.skip("writes one file")
    (tmp_path / case.into_folder).symlink_to(case.inputs[0])
    error = refused(command, case, tmp_path, options, capsys)
    assert case.into_folder in error


def test_foreign_files_under_the_names_it_would_write_are_kept(command, case, options, capsys, tmp_path):
    if case.into_folder:
        (tmp_path / case.into_folder).write_text("mine")
        assert case.into_folder in refused(command, case, tmp_path, options, capsys)
        return
    for suffix in (*case.suffixes, ".run.json"):
        folder = tmp_path / suffix
        folder.mkdir()
        output = folder / "x.y.h5"
        output.with_suffix(suffix).write_text("mine")
        assert output.with_suffix(suffix).name in refused(command, case, output, options, capsys)


def test_an_artefact_of_another_kind_is_kept(command, case, options, capsys, tmp_path):
    other = clips(tmp_path / "other.h5") if command.startswith("fuse") else fused(tmp_path / "other.h5")
    output = tmp_path / "out" / (case.into_folder or "x.h5")
    output.parent.mkdir()
    shutil.copy(other, output)
    assert "is of kind" in refused(command, case, target(command, case, output), options, capsys)


def clips(path):
    return mocap_clips.write(path, mocap_clips.every(frames=3, repeats=1))


@pytest.mark.parametrize("name", ["mesh.gz", "page.html", "run.1", "-", "folder"])
def test_names_that_cannot_be_are_refused(command, case, options, capsys, tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    output = tmp_path / ("file" if case.into_folder and name != "-" else name)
    refused(command, case, output, options, capsys)


def test_no_case_needs_more_than_it_says(command, case, capsys, tmp_path):
    """Each line of the table would run: only its output was at fault."""
    output = tmp_path / "out" if case.into_folder else tmp_path / "x.h5"
    assert cli.main(line(command, case, output, ["-n"])) == 0
    assert "run, since it does not exist" in capsys.readouterr().err


def test_a_motion_is_not_replaced_by_its_answers(made, options, capsys, tmp_path):
    """The side file is the input: take.csv, and -o take.h5."""
    case = made("mocap-classify")
    take = tmp_path / "take.csv"
    take.write_text("time,hips.x,hips.y,hips.z\n0,0,1,0\n.1,0,1,0\n")
    learnt = case.words[0]
    before = take.read_bytes()
    assert cli.main(["mocap-classify", learnt, str(take), "-o", str(tmp_path / "take.h5"), *options]) == 1
    assert "take.csv: is an input of this run" in capsys.readouterr().err
    assert take.read_bytes() == before


def test_a_dry_run_of_sound_inputs_makes_nothing(command, case, capsys, tmp_path):
    output = tmp_path / "out" / (case.into_folder or "x.h5")
    assert cli.main(line(command, case, target(command, case, output), ["--dry-run"])) == 0
    assert capsys.readouterr().out == ""
    assert contents([tmp_path]) == {}


def test_a_dry_run_refuses_at_once_what_the_run_would(command, case, capsys, tmp_path):
    """A file of another kind, or an empty folder, in place of each input in turn."""
    output = tmp_path / "out" / (case.into_folder or "x.h5")
    for word in (word for word in case.words if Path(word).exists()):
        wrong = tmp_path / f"wrong{Path(word).suffix}"
        wrong.mkdir() if Path(word).is_dir() else wrong.write_bytes(b"x")
        words = tuple(str(wrong) if word == other else other for other in case.words)
        other = replace(case, words=words, inputs=(wrong,))
        refused(command, other, target(command, case, output), ["--dry-run"], capsys)
        wrong.rmdir() if wrong.is_dir() else wrong.unlink()
