"""SIGTERM, which a scheduler or `docker stop` sends, ends a real command so that nothing of it stays: neither the
archive that it unpacked nor a file half written. Compare test_kill.py, where nothing can be tidied.
"""

import os
import signal
import subprocess
import sys
import tarfile
import time
from pathlib import Path

import numpy as np
import pytest

from ipcli.io.files import atomic
from tests.fixtures.mocap_clips import every, write_groups

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs signals")
AT_A_RENAME = """
import os, signal, sys
from ipcli.cli.main import main
left = [int(sys.argv.pop(1))]
def counting(name):
    function = getattr(os, name)
    def counted(*paths):
        if not left[0]:
            os.kill(os.getpid(), signal.SIGTERM)
        left[0] -= 1
        function(*paths)
    setattr(os, name, counted)
counting("replace"), counting("link")
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def place(tmp_path):
    """An archive of motions, and folders for results and for temporary files."""
    for name in ("out", "temporary"):
        (tmp_path / name).mkdir()
    for clip in every(repeats=1):
        path = tmp_path / "set" / clip.label / clip.actor / f"{clip.name}.npz"
        path.parent.mkdir(parents=True)
        skeleton = {"joints": clip.motion.skeleton.joints, "parents": clip.motion.skeleton.parents}
        np.savez(path, positions=clip.motion.positions, rate=clip.motion.rate, **skeleton)
    with tarfile.open(tmp_path / "set.tar", "w") as tar:
        tar.add(tmp_path / "set", ".")
    return tmp_path


def start(place, *arguments):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "TMPDIR": str(place / "temporary")}
    return subprocess.Popen([sys.executable, *arguments], env=environment, stderr=subprocess.PIPE, text=True)


def unpacked(place):
    return list((place / "temporary").glob("ipcli-*/**/*.npz"))


@pytest.mark.parametrize("renamed", [0, 1])
def test_files_half_written_and_the_unpacked_archive_are_removed(place, renamed):
    line = ["import-clips", str(place / "set.tar"), "-o", str(place / "out" / "x.clips.h5")]
    with start(place, "-c", AT_A_RENAME, str(renamed), *line) as process:
        assert process.communicate()[1] == "Error: terminated\n"
    assert process.returncode == 143
    assert list((place / "temporary").iterdir()) == []
    assert not [path for path in (place / "out").iterdir() if atomic.ORPHAN.fullmatch(path.name)]
    assert not (place / "out" / "x.clips.h5").exists()


def test_long_work_is_ended_at_any_moment(place):
    groups = write_groups(place / "groups.toml")
    words = ["--groups", str(groups), "--set", "learning.mixture.sweeps=1000000", "-o", str(place / "out" / "x.h5")]
    with start(place, "-m", "ipcli", "mocap-train", str(place / "set.tar"), *words) as process:
        end = time.monotonic() + 60
        while not unpacked(place):
            assert process.poll() is None
            assert time.monotonic() < end
            time.sleep(0.02)
        time.sleep(0.3)  # in the midst of whatever follows
        process.send_signal(signal.SIGTERM)
        assert process.communicate(timeout=20)[1] == "Error: terminated\n"
    assert process.returncode == 143
    assert list((place / "temporary").iterdir()) == []
    assert not (place / "out" / "x.h5").exists()
