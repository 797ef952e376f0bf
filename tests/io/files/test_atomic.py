"""A reader sees the old file or the new one, whatever befalls the writer."""

import os
import signal
import subprocess
import sys
import time

import pytest

from ipcli.io.files import atomic

WRITER = """
import sys, time
from pathlib import Path
from ipcli.io.files import atomic
with atomic.replacing(Path(sys.argv[1])) as temporary:
    temporary.write_bytes(b"new" * 1000)
    print("written", flush=True)
    time.sleep(60)
"""


def test_write_makes_the_folder_and_replaces_the_file_leaving_nothing_else(tmp_path):
    path = tmp_path / "a" / "b" / "f.txt"
    atomic.write_text(path, "é\n")
    atomic.write_text(path, "ü\n")
    assert path.read_bytes() == "ü\n".encode()
    assert list(path.parent.iterdir()) == [path]


def test_an_exception_leaves_the_old_file_and_no_temporary(tmp_path):
    atomic.write_bytes(tmp_path / "f", b"old")

    def fail_half_way():
        with atomic.replacing(tmp_path / "f") as temporary:
            temporary.write_bytes(b"half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_half_way()
    assert [(entry.name, entry.read_bytes()) for entry in tmp_path.iterdir()] == [("f", b"old")]


def test_forgetting_to_write_is_an_error_and_keeps_the_old_file(tmp_path):
    atomic.write_bytes(tmp_path / "f", b"old")
    with pytest.raises(FileNotFoundError), atomic.replacing(tmp_path / "f"):
        pass
    assert (tmp_path / "f").read_bytes() == b"old"


def test_a_kill_during_the_write_leaves_the_old_file_and_a_sweep_later_cleans(tmp_path):
    path = tmp_path / "f.h5"
    atomic.write_bytes(path, b"old")
    env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, env=env) as writer:
        assert writer.stdout.readline() == b"written\n"
        writer.send_signal(signal.SIGKILL)
    assert path.read_bytes() == b"old"
    (orphan,) = (entry for entry in tmp_path.iterdir() if entry != path)
    assert atomic.ORPHAN.fullmatch(orphan.name)
    assert orphan.stat().st_size == 3000
    atomic.sweep(tmp_path)
    assert orphan.exists()
    day_ago = time.time() - atomic.DAY - 60
    os.utime(orphan, (day_ago, day_ago))
    atomic.sweep(tmp_path)
    assert list(tmp_path.iterdir()) == [path]


def test_a_sweep_touches_only_names_that_replacing_gives(tmp_path):
    names = ["notes.tmp", ".hidden", ".f.tmp", ".f.12x.tmp", "f.12.tmp"]
    for name in names:
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (0, 0))
    atomic.sweep(tmp_path)
    atomic.sweep(tmp_path / "absent")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == sorted(names)
