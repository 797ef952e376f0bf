"""Digests depend on contents and on nothing else; records carry nothing that varies."""

import hashlib
import json
import os

import pytest

from ipcli import provenance
from ipcli.errors import IpcliError


def tree(root, files):
    for name, data in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(data)
    return root


FILES = {"b.txt": b"two", "a/c.txt": b"one", "a/d.txt": b""}


def test_a_file_has_the_digest_that_sha256sum_prints(tmp_path):
    data = os.urandom(3_000_000)
    (tmp_path / "f").write_bytes(data)
    assert provenance.sha256(tmp_path / "f") == hashlib.sha256(data).hexdigest()


def test_a_folder_may_move_but_not_change(tmp_path):
    digest = provenance.sha256(tree(tmp_path / "one", FILES))
    assert provenance.sha256(tree(tmp_path / "two", dict(reversed(FILES.items())))) == digest
    tree(tmp_path / "two", {".hidden": b"x", "a/.b.txt.77.tmp": b"y"})
    assert provenance.sha256(tmp_path / "two") == digest
    changes = [{"b.txt": b"tw0"}, {"new": b""}, {"a/c.txt": b"two", "b.txt": b"one"}]
    digests = {provenance.sha256(tree(tmp_path / f"changed{i}", FILES | change)) for i, change in enumerate(changes)}
    (tmp_path / "one" / "b.txt").rename(tmp_path / "one" / "e.txt")
    assert len(digests | {digest, provenance.sha256(tmp_path / "one")}) == 5


def test_several_files_have_one_digest_whatever_their_order_and_folder(tmp_path):
    one, two = tree(tmp_path / "one", {"x": b"1", "y": b"2"}), tree(tmp_path / "two", {"x": b"1", "y": b"2"})
    assert provenance.sha256([one / "x", one / "y"]) == provenance.sha256([two / "y", two / "x"])
    assert provenance.sha256([one / "x", one / "y"]) != provenance.sha256([one / "x"])


def test_what_is_not_there_is_named(tmp_path):
    with pytest.raises(IpcliError, match="absent: cannot be read: No such file"):
        provenance.record("c", {}, [tmp_path / "absent"], "fused-depth", 0)


def test_the_digest_depends_on_each_part_but_not_on_the_order_of_keys():
    base = provenance.digest({"a": 1, "b": {"c": 2}}, ["x", "y"], 1, 0)
    assert provenance.digest({"b": {"c": 2}, "a": 1}, ["x", "y"], 1, 0) == base
    others = [
        provenance.digest({"a": 1, "b": {"c": 3}}, ["x", "y"], 1, 0),
        provenance.digest({"a": 1, "b": {"c": 2}}, ["y", "x"], 1, 0),
        provenance.digest({"a": 1, "b": {"c": 2}}, ["x", "y"], 2, 0),
        provenance.digest({"a": 1, "b": {"c": 2}}, ["x", "y"], 1, 1),
    ]
    assert len({base, *others}) == 5


def test_a_record_repeats_in_another_folder_and_names_no_path(tmp_path):
    records = [
        provenance.record("fuse-depth", {"a": 1}, [tree(tmp_path / place / "in", FILES)], "fused-depth", 7)
        for place in ("one", "two")
    ]
    assert json.dumps(records[0]) == json.dumps(records[1])
    assert str(tmp_path) not in json.dumps(records[0])
    assert records[0]["inputs"][0]["name"] == "in"


def test_the_run_record_holds_plain_json_with_sane_numbers():
    record = json.loads(json.dumps(provenance.run_record(1.25), allow_nan=False))
    assert record["elapsed_s"] == 1.25
    assert 10 < record["max_rss_mb"] < 1e5
    assert record["libraries"].keys() >= {"numpy", "h5py"}
