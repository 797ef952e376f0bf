"""The limit on memory: how it is said, what the machine and its control groups allow, what is refused."""

import pytest

from ipcli import memory
from ipcli.errors import FormatError, ParameterError


@pytest.mark.parametrize(
    ("text", "amount"),
    [("2GB", 2e9), ("2 gb", 2e9), ("1.5G", 1.5e9), ("512MiB", 512 * 2**20), ("100000000", 1e8), ("200000k", 2e8)],
)
def test_amounts(text, amount):
    assert memory.parse(text) == amount


@pytest.mark.parametrize("text", ["", "much", "-1GB", "2XB", "1e9", "10kB", "0%", "2GB 3", "9" * 40, "999999999999TB"])
def test_what_is_no_amount_is_refused(text):
    with pytest.raises(ParameterError, match="--max-memory"):
        memory.parse(text)


def test_a_share_is_of_the_machine(monkeypatch):
    monkeypatch.setattr(memory, "machine", lambda: 8 * 10**9)
    monkeypatch.delenv(memory.VARIABLE, raising=False)
    assert memory.budget() == 6 * 10**9
    monkeypatch.setenv(memory.VARIABLE, "50%")
    assert memory.budget() == 4 * 10**9


def test_what_is_set_holds_for_processes_that_are_started(monkeypatch):
    monkeypatch.setenv(memory.VARIABLE, "1GB")
    memory.set_budget(None)
    assert memory.budget() == 10**9
    memory.set_budget("3GB")
    assert memory.budget() == 3 * 10**9
    with pytest.raises(ParameterError):
        memory.set_budget("all")
    assert memory.budget() == 3 * 10**9


@pytest.mark.parametrize(
    ("membership", "files", "limits"),
    [
        ("0::/a/b\n", {"a/b/memory.max": "max\n", "a/memory.max": "700000000\n"}, [700000000]),
        ("0::/\n", {"memory.max": "max\n"}, []),
        ("5:cpu:/x\n4:memory:/x\n", {"memory/x/memory.limit_in_bytes": "500000000\n"}, [500000000]),
        ("nonsense\n", {}, []),
    ],
)
def test_control_groups_and_those_above_them_limit(tmp_path, monkeypatch, membership, files, limits):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "membership").write_text(membership)
    monkeypatch.setattr(memory, "GROUPS", tmp_path)
    monkeypatch.setattr(memory, "MEMBERSHIP", tmp_path / "membership")
    assert memory._groups() == limits


def test_what_needs_more_is_refused_in_one_line_with_both_figures(monkeypatch):
    monkeypatch.setenv(memory.VARIABLE, "1GB")
    memory.check("a.npz", 10**9, "arrays")
    with pytest.raises(FormatError, match=r"a\.npz: .*at most 1 GB, got arrays, which take 3 GB.*--max-memory"):
        memory.check("a.npz", 3 * 10**9, "arrays")
