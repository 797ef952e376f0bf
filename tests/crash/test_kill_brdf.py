"""brdf-train killed at any moment goes on with what is left, to the bytes of a run that was not disturbed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ipcli.cli.main import main
from tests.fixtures.brdf_scenes import LIST, QUICK, library

ROOT = Path(__file__).parents[2]
KILLED = """
import os, signal, sys
from pathlib import Path
from ipcli.cli.main import main
seen, (count, end) = [], sys.argv.pop(1).split("*")
replace = os.replace
def counted(source, target):
    seen.append(Path(target).name.endswith(end))
    if sum(seen) > int(count):
        os.kill(os.getpid(), signal.SIGKILL)
    replace(source, target)
os.replace = counted
main(sys.argv[1:])
"""

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")


def test_a_run_killed_between_materials_and_lessons_ends_in_the_same_bytes(tmp_path, monkeypatch):
    whole, output = library(tmp_path / "whole.h5"), tmp_path / "x.h5"
    arguments = ["brdf-train", str(LIST), *QUICK, "-o", str(output), "--quiet"]
    for moment in ("2*.npz", "4*.npz"):  # each run adds as many before it dies
        code = [sys.executable, "-c", KILLED, moment, *arguments]
        died = subprocess.run(code, cwd=ROOT, env=dict(os.environ, PYTHONHASHSEED="0"))
        assert died.returncode == -signal.SIGKILL
        assert not output.exists()
    (left,) = tmp_path.glob(".x.h5.*.work")
    kept = len(list(left.glob("*.npz")))
    assert kept == 6  # five materials and the plain ones; no lesson yet
    assert main(arguments) == 0
    assert output.read_bytes() == whole.read_bytes()
    assert not left.exists()
