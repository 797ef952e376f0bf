"""mocap-train and mocap-evaluate killed at any moment go on where their chains were, to the bytes of a run that was not
disturbed.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ipcli.cli.main import main
from tests.fixtures.mocap_clips import QUICK, every, write, write_groups

ROOT = Path(__file__).parents[2]
SUFFIXES = (".h5", ".html")
COMMANDS = {
    "mocap-train": ("--frames", "30", *QUICK[2:]),
    "mocap-evaluate": ("--split", "leave-one-out", "--frames", "30", *QUICK[2:]),
}
KILLED_WHEN = """
import os, signal, sys
from pathlib import Path
from ipcli.cli.main import main
seen, (count, end) = [], sys.argv.pop(1).split("*")
def counting(name):
    function = getattr(os, name)
    def counted(source, target):
        seen.append(Path(target).name.endswith(end))
        if sum(seen) > int(count):
            os.kill(os.getpid(), signal.SIGKILL)
        function(source, target)
    setattr(os, name, counted)
counting("replace"), counting("link")
main(sys.argv[1:])
"""
DONE = ".done.npz"  # what a mixture leaves that has been learnt
MOMENTS = (f"5*{DONE}", "20*.chains.npz", "0*.h5")  # before the next file of such a name, after so many

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Clips and groups; those of two people are enough."""
    folder = tmp_path_factory.mktemp("clips")
    write(folder / "x.clips.h5", [one for one in every(12) if one.actor in ("ann", "bob")])
    write_groups(folder / "groups.toml")
    return folder


def arguments(command, source, folder):
    return [
        command,
        str(source / "x.clips.h5"),
        "--groups",
        str(source / "groups.toml"),
        *COMMANDS[command],
        "-o",
        str(folder / "x.h5"),
    ]


def contents(folder):
    return {suffix: (folder / f"x{suffix}").read_bytes() for suffix in SUFFIXES}


@pytest.fixture(scope="module", params=list(COMMANDS))
def undisturbed(request, source, tmp_path_factory):
    """A command and the bytes that it writes."""
    folder = tmp_path_factory.mktemp("undisturbed")
    assert main(arguments(request.param, source, folder)) == 0
    return request.param, contents(folder)


def mixtures(monkeypatch):
    """Names of the mixtures that this process learns from now on."""
    learnt, replace = [], os.replace

    def counted(source, target):
        learnt.extend([Path(target).name] if Path(target).name.endswith(DONE) else [])
        replace(source, target)

    monkeypatch.setattr(os, "replace", counted)
    return learnt


@pytest.mark.parametrize("moment", MOMENTS)
def test_killed_before_any_file_it_goes_on_and_learns_nothing_twice(undisturbed, source, tmp_path, monkeypatch, moment):
    command, whole = undisturbed
    line = [sys.executable, "-c", KILLED_WHEN, moment, *arguments(command, source, tmp_path)]
    done = subprocess.run(line, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert all(
        not path.exists() or path.read_bytes() == whole[path.suffix]
        for path in (tmp_path / f"x{suffix}" for suffix in SUFFIXES)
    )
    before = {path.name for path in tmp_path.rglob(f"*{DONE}")}
    learnt = mixtures(monkeypatch)
    assert main(arguments(command, source, tmp_path)) == 0
    assert contents(tmp_path) == whole
    assert not before & {*learnt}
    assert before or learnt
    assert len({*learnt}) == len(learnt)
    assert not [path for path in tmp_path.iterdir() if path.is_dir()]


def test_killed_at_some_time_with_workers_it_comes_to_the_same_bytes(undisturbed, source, tmp_path):
    command, whole = undisturbed
    line = [sys.executable, "-m", "ipcli", *arguments(command, source, tmp_path), "--executor", "processes:2"]
    process = subprocess.Popen(
        line,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    time.sleep(2.5)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert main(arguments(command, source, tmp_path)) == 0
    assert contents(tmp_path) == whole
