"""The attack on all readers: whatever is registered is attacked, faults are found, and a short attack finds none."""

import os
import signal
import sys

import pytest

from ipcli.errors import FormatError
from ipcli.io.files import text
from tests.fixtures import house
from tests.fixtures.attack import child, run
from tests.fixtures.attack.seed import Content, Seed, written
from tests.fixtures.attack.seeds import SEEDS, registered

FEW = 2


def test_everything_that_is_registered_has_a_seed():
    assert registered() - set(SEEDS) == set()


def test_every_reader_of_io_is_called_by_a_seed(tmp_path):
    readers = {
        (str(module.path), function.name)
        for module in house.modules("ipcli/io")
        for function in module.functions
        if function.name.split("_")[0] in ("read", "open")
    }
    called = set()

    def note(frame, event, _):
        if event == "call":
            called.add((frame.f_code.co_filename, frame.f_code.co_name))

    for number, seed in enumerate(seed for name, seed in SEEDS.items() if not name.startswith("artefacts/")):
        (tmp_path / str(number)).mkdir()
        opened = seed.write(tmp_path / str(number))
        sys.setprofile(note)
        try:
            child.outcome(seed, opened)
        finally:
            sys.setprofile(None)
    assert readers - called == set()


def seed_of(read):
    return Seed(lambda folder: written(folder, "a.txt", "1 2\n3 4\n"), read)


def refuse(path):
    raise FormatError(path, "no")


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        (lambda path: Content(len(text.read_text(path))), ("read", "")),
        (refuse, ("refused", "")),
        (lambda path: [][0], ("internal", "? IndexError: list index out of range")),
        (lambda path: b"x" * (1 << 60), ("memory", "? MemoryError: ")),
    ],
)
def test_what_comes_of_a_file_is_told(tmp_path, read, expected):
    seed = seed_of(read)
    assert child.outcome(seed, seed.write(tmp_path))[:2] == expected


def test_a_child_that_dies_or_hangs_is_found_and_replaced(monkeypatch):
    def end(journal, jobs, seed, folder):
        """Reads one file, then dies at the next; the last child comes to the end."""
        (name, first, stop), *rest = jobs
        with journal.open("a") as stream:
            for number in range(first, stop):
                child._note(stream, {"begun": [name, number]})
                if number == 1:
                    return -(signal.SIGSEGV if name == "a" else signal.SIGALRM)
                child._note(stream, {"name": name, "number": number, "damage": "", "outcome": "read", "detail": ""})
        jobs[:] = rest
        return 0 if not rest else end(journal, jobs, seed, folder)

    monkeypatch.setattr(run, "_child", end)
    entries = run.attack({"a": 3, "b": 3}, 0)
    assert [(e["name"], e["number"], e["outcome"]) for e in entries] == [
        ("a", 0, "read"), ("a", 1, "crash"), ("a", 2, "read"), ("b", 0, "read"), ("b", 1, "hang"), ("b", 2, "read"),
    ]  # fmt: skip
    assert "crash x 1: a number 1 (?): SIGSEGV" in run.table(entries)


def test_the_same_seed_damages_alike(tmp_path):
    name = "motion/files/.bvh"
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    first, again = (child.Attack(name, tmp_path / place) for place in ("one", "two"))
    assert [first(n, 0) for n in range(20)] == [again(n, 0) for n in range(20)]
    assert {first(n, 0)["outcome"] for n in range(20)} >= {"read", "refused"}


@pytest.mark.skipif(os.name != "posix", reason="limits are those of POSIX")
def test_a_short_attack_finds_no_fault():
    entries = run.attack({name: FEW for name, seed in SEEDS.items() if seed.weight == 1}, 1)
    assert len(entries) == FEW * sum(seed.weight == 1 for seed in SEEDS.values())
    assert [line for line in run.table(entries) if line.startswith(run.FAULTS)] == []


REFUSED = {  # what was an internal error, a hang or a silent loss, as the smallest change to a seed
    "gaze/gaze_files/pupil_core": ("gaze.csv", b"0.9,0.25", b"0.9,0.2'5"),
    "gaze/gaze_files/aria": ("gaze.csv", b"0.1,0.2", b"0.1x,0.2"),
    "gaze/gaze_files/tobii": ("gazedata.gz", b"\x03\xabV*", b"\x03\xff\xff\xff"),
    "gaze/tum": ("depth.txt", None, b"# a comment\n"),
    "materials/probes": ("a.npy", b"(4, 8, 3)", b"(4, 8, 3("),
    "meshes/ply": ("a.ply", b"element vertex 4", b"element vertex " + b"9" * 5000),
    "motion/utkinect": ("joints/actionLabel.txt", None, b"s01_e"),
    "views/colmap": ("sparse/cameras.txt", b"1 PINHOLE 16 12", b"1 PINHOLE 0 12"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_attacks_found_is_refused(tmp_path, name):
    file, before, after = REFUSED[name]
    opened = SEEDS[name].write(tmp_path)
    data = (tmp_path / file).read_bytes()
    assert before is None or before in data
    (tmp_path / file).write_bytes(after if before is None else data.replace(before, after, 1))
    assert child.outcome(SEEDS[name], opened)[:2] == ("refused", "")


LISTS = {  # files whose end can be lost without a rule being broken, and a line that a cut leaves whole
    "fixations/folder": "fixations.csv",
    "gaze/trajectories/tum": "a.tum",
    "gaze/tum": "rgb.txt",
    "meshes/read.obj": "a.obj",
    "motion/files": "manifest.csv",
    "motion/files/.csv": "a.csv",
    "motion/files/.txt": "a14_s03_e02_skeleton3D.txt",
    "motion/utkinect": "joints/actionLabel.txt",
}


@pytest.mark.parametrize("name", LISTS)
def test_a_list_that_lost_its_last_end_of_line_is_read_with_a_word(tmp_path, name):
    opened, path = SEEDS[name].write(tmp_path), tmp_path / LISTS[name]
    whole = child.outcome(SEEDS[name], opened)[2]
    path.write_bytes(path.read_bytes().rstrip(b" \n"))
    found = child.outcome(SEEDS[name], opened)[2]
    assert (found.items, found.words) == (whole.items, whole.words + 1)
