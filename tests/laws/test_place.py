"""Of every command: what it makes does not depend on where its inputs lie or from where they are named."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from ipcli.cli.main import main
from ipcli.io.files import h5
from tests.fixtures.commands import CASES, line

LONG = {"mocap-train", "tune-fusion", "brdf-train", "brdf-model", "fuse-depth", "evaluate-fusion", "gaze-sfm"}
TO_THE_END = {"merge-depth": ("--agree", "1")}  # what makes a run on such small inputs find anything


def made(name, case, output):
    """The arrays of what the command writes."""
    target = output / case.into_folder if case.into_folder else output
    assert main(line(name, case, output, ["--quiet", *TO_THE_END.get(name, ())])) == 0
    return h5.read(target, h5.peek(target).kind).arrays


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in CASES])
def test_a_copy_elsewhere_named_from_there_gives_the_same_numbers(tmp_path, monkeypatch, name):
    here, there = tmp_path / "here", tmp_path / "over there é"
    here.mkdir()
    case = CASES[name](here)
    shutil.copytree(here, there)
    file = "out" if case.into_folder else "out.h5"
    one = made(name, case, tmp_path / "one" / file)
    monkeypatch.chdir(there)
    shutil.rmtree(here)
    words = (os.path.relpath(word, here) if word.startswith(str(here)) else word for word in case.words)
    other = made(name, replace(case, words=tuple(words)), tmp_path / "other" / file)
    assert set(one) == set(other)
    for field, array in one.items():
        np.testing.assert_array_equal(other[field], array, err_msg=field)
