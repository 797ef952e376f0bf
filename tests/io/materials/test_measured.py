"""Measured materials: what was written is read, what is damaged is refused with FormatError."""

import json

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.materials import measured


def networks(path, names=("a", "b"), **changed):
    arrays = {
        key: np.random.default_rng(0).normal(size=(len(names), *shape)).astype(np.float32)
        for key, shape in measured.LAYERS.items()
    }
    np.savez(path, names=np.array(names), **(arrays | changed))
    return arrays


def test_the_network_of_a_name_is_its_row(tmp_path):
    arrays = networks(tmp_path / "n.npz")
    read = measured.read_network(tmp_path / "n.npz", "b")
    np.testing.assert_array_equal(read["k2"], arrays["k2"][1])


def test_unknown_names_name_the_nearest(tmp_path):
    networks(tmp_path / "n.npz", ("brass", "steel"))
    with pytest.raises(FormatError, match="did you mean 'brass'"):
        measured.read_network(tmp_path / "n.npz", "bras")


@pytest.mark.parametrize("bad", [np.zeros((2, 6, 20)), np.full((2, 6, 21), np.nan)])
def test_unsound_networks_are_refused(tmp_path, bad):
    networks(tmp_path / "n.npz", k1=bad)
    with pytest.raises(FormatError, match="k1 is not sound"):
        measured.read_network(tmp_path / "n.npz", "a")


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"abc": {"a": {"kD": [1, 2], "A": [1, 1, 1], "BCior": [1, 1, 1]}}}', "[" * 100000]
)
def test_unsound_fits_are_refused(tmp_path, text):
    path = tmp_path / "abc.json"
    path.write_text(text)
    with pytest.raises(FormatError):
        measured.read_abc(path, "a")


def test_a_fit_is_read_by_its_parts(tmp_path):
    path = tmp_path / "abc.json"
    path.write_text(json.dumps({"abc": {"a": {"kD": [0.1, 0.2, 0.3], "A": [1, 2, 3], "BCior": [10, 0.5, 1.4]}}}))
    fit = measured.read_abc(path, "a")
    assert (fit["width"], fit["falloff"], fit["eta"], fit["scale"]) == (10, 0.5, 1.4, (1, 2, 3))


def test_a_table_of_another_size_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "x.binary"
    path.write_bytes(np.array([90, 90, 180], "<i4").tobytes() + b"\0" * 64)
    with pytest.raises(FormatError, match="expected 34992012 bytes, got 76"):
        measured.read_table(path)
