"""fuse-depth killed at any moment, or on a full disk, leaves a file whole or not at all, and a re-run gives the same
bytes.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ipcli.io.files import atomic, h5, ply
from ipcli.stages.kit import outputs
from tests.fixtures.fusion_scenes import scene, write

ROOT = Path(__file__).parents[2]
SUFFIXES = (".h5", ".ply", ".html")
SHARES = (0.1, 0.5, 0.75, 0.85, 0.9, 0.95, 0.98)  # of the time that an undisturbed run takes


def arguments(source, folder):
    output, quick = str(folder / "x.fused.h5"), "fusion.solver.iterations=200"
    return [sys.executable, "-m", "ipcli", "fuse-depth", str(source), "-o", output, "--set", quick]


def start(source, folder, **options):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        arguments(source, folder), env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options
    )


def contents(folder):
    return {suffix: (folder / "x.fused").with_suffix(".fused" + suffix).read_bytes() for suffix in SUFFIXES}


def strays(folder):
    return [path for path in folder.iterdir() if path.name.startswith(".")] if folder.is_dir() else []


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "scene.views.h5", scene())


@pytest.fixture(scope="module")
def undisturbed(source, tmp_path_factory):
    """Bytes of the files and the seconds of a run whose kernels are compiled."""
    folder, elapsed = tmp_path_factory.mktemp("undisturbed"), 0.0
    for name in ("first", "second"):
        begun = time.monotonic()
        out, err = start(source, folder / name).communicate()
        elapsed = time.monotonic() - begun
        assert out
        assert not err
    assert contents(folder / "first") == contents(folder / "second")
    assert not strays(folder / "second")
    return contents(folder / "second"), elapsed


def assert_whole_or_absent(folder, whole):
    """Each file under its name is complete; the artefact, which comes last, vouches for the others."""
    files = {suffix: folder / f"x.fused{suffix}" for suffix in SUFFIXES}
    for suffix, path in files.items():
        assert not path.exists() or path.read_bytes() == whole[suffix]
    if files[".h5"].exists():
        assert all(path.exists() for path in files.values())


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_a_run_killed_at_any_moment_can_be_run_again_to_the_same_bytes(source, undisturbed, tmp_path):
    whole, elapsed = undisturbed
    for share in SHARES:
        folder = tmp_path / f"{share}"
        process = start(source, folder)
        time.sleep(max(0.2, share * elapsed))
        process.kill()
        process.communicate()
        assert process.returncode in (-signal.SIGKILL, 0)
        assert_whole_or_absent(folder, whole)
    rerun_in_one(source, [tmp_path / f"{share}" for share in SHARES], whole)


def rerun_in_one(source, folders, whole):
    """Run to the end in this process; what the killed runs left is swept once it is a day old."""
    from ipcli.cli.main import main

    for folder in folders:
        for stray in strays(folder):
            assert atomic.ORPHAN.fullmatch(stray.name) or stray == outputs.journal_path(folder / "x.fused.h5")
            os.utime(stray, (0, time.time() - 2 * atomic.DAY))
        assert main(arguments(source, folder)[3:]) == 0
        assert contents(folder) == whole
        h5.read(folder / "x.fused.h5", "fused-depth"), ply.read(folder / "x.fused.ply")
        if strays(folder):  # up to date: nothing was written, nothing swept
            assert main([*arguments(source, folder)[3:], "--overwrite"]) == 0
        assert not strays(folder)
        assert contents(folder) == whole


KILLED_BETWEEN_FILES = """
import os, signal, sys
from pathlib import Path
from ipcli.cli.main import main
left = [int(sys.argv.pop(1))]
def counting(name):
    function = getattr(os, name)
    def counted(*paths):
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1
        function(*paths)
    setattr(os, name, counted)
counting("replace"), counting("link")
main(sys.argv[1:])
"""


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
@pytest.mark.parametrize("published", range(8))
def test_a_run_killed_between_any_two_files_can_be_run_again_to_the_same_bytes(
    source, undisturbed, tmp_path, published
):
    """Page, mesh and artefact are renamed once each while they are written; then the journal is, the three get their
    names, and the run record.
    """
    whole, _ = undisturbed
    command = [sys.executable, "-c", KILLED_BETWEEN_FILES, str(published), *arguments(source, tmp_path)[3:]]
    done = subprocess.run(command, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert_whole_or_absent(tmp_path, whole)
    assert strays(tmp_path)
    rerun_in_one(source, [tmp_path], whole)


@pytest.mark.skipif(os.name == "nt", reason="needs RLIMIT_FSIZE")
@pytest.mark.parametrize("limit", [1_000, 100_000, 200_000])
def test_a_full_disk_is_exit_1_in_one_line_and_leaves_nothing(source, undisturbed, tmp_path, limit):
    """The files have about 160, 280 and 290 kB."""
    import resource

    folder = tmp_path / "out"
    process = start(source, folder, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    out, err = process.communicate()
    assert process.returncode == 1
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("Error: ")
    assert not folder.exists() or not list(folder.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="needs RLIMIT_FSIZE")
def test_a_full_disk_keeps_the_files_that_were_there(source, undisturbed, tmp_path):
    import resource

    from ipcli.cli.main import main

    assert main(arguments(source, tmp_path)[3:]) == 0
    before = contents(tmp_path)
    command = [*arguments(source, tmp_path), "--overwrite", "--lambda", "1"]
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))  # noqa: E731
    done = subprocess.run(command, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, preexec_fn=limit)
    assert done.returncode == 1
    assert contents(tmp_path) == before
    assert not strays(tmp_path)
