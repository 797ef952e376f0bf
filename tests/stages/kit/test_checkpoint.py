"""What a killed run finds again, and what it does not."""

from __future__ import annotations

import numpy as np
import pytest

from ipcli.errors import IpcliError
from ipcli.stages.kit.checkpoint import Checkpoint

STATE = {"labels": np.arange(5, dtype=np.int32), "hyper": np.array([0.5, np.nan])}


@pytest.fixture
def checkpoint(tmp_path):
    return Checkpoint.of(tmp_path / "out" / "model.h5", "ab" * 32)


@pytest.mark.parametrize("name", ["kick, legs", "a/b", "..", "ü\\:*"])
def test_what_is_saved_is_found_again_by_any_name(checkpoint, name):
    assert checkpoint.load(name) is None
    checkpoint.save(name, {"labels": np.zeros(1)})
    checkpoint.save(name, STATE)
    found = checkpoint.load(name)
    assert found.keys() == STATE.keys()
    for key, array in STATE.items():
        np.testing.assert_array_equal(found[key], array)
        assert found[key].dtype == array.dtype
    assert checkpoint.load(name + "x") is None
    assert all(path.parent == checkpoint.folder for path in checkpoint.folder.rglob("*"))


def test_another_run_takes_none_of_it(checkpoint, tmp_path):
    checkpoint.save("a", STATE)
    assert Checkpoint.of(tmp_path / "out" / "model.h5", "cd" * 32).load("a") is None
    assert Checkpoint.of(tmp_path / "out" / "other.h5", "ab" * 32).load("a") is None


def test_a_damaged_file_counts_as_none(checkpoint):
    checkpoint.save("a", STATE)
    (path,) = checkpoint.folder.iterdir()
    path.write_bytes(path.read_bytes()[:-40])
    assert checkpoint.load("a") is None


def test_what_is_no_number_is_refused_and_the_old_stays(checkpoint):
    checkpoint.save("a", STATE)
    with pytest.raises(IpcliError, match="numbers only"):
        checkpoint.save("a", {"labels": np.array(["text"])})
    assert checkpoint.load("a").keys() == STATE.keys()


def test_clearing_leaves_nothing(checkpoint):
    checkpoint.save("a", STATE)
    checkpoint.clear()
    checkpoint.clear()
    assert not list(checkpoint.folder.parent.iterdir())


def test_names_of_any_length_and_script_are_kept_apart(tmp_path):
    work = Checkpoint(tmp_path / "work")
    names = ["両手を高く上げて大きく左右に振りながらゆっくり歩く動作" * n for n in (1, 2, 9)] + ["a" * 300, "a" * 301]
    for number, name in enumerate(names):
        work.save(name, {"x": np.array([number])})
    assert [int(work.load(name)["x"][0]) for name in names] == [0, 1, 2, 3, 4]
