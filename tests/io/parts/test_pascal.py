"""PASCAL-Part annotations, sound and damaged."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.parts import masks

LABELS = np.zeros((20, 30), np.uint8)
LABELS[2:10, 3:20] = 1
LABELS[10:18, 5:9] = 2


def pascal_file(path):
    from scipy.io import savemat

    def part(name, number):
        return {"part_name": name, "mask": (number == LABELS).astype(np.uint8)}

    thing = {"class": "dog", "mask": (LABELS > 0).astype(np.uint8), "parts": [part("torso", 1), part("leg", 2)]}
    savemat(path, {"anno": {"imname": "x", "objects": [thing, thing]}})


def test_pascal_part(tmp_path):
    pascal_file(tmp_path / "a.mat")
    found = masks.read(tmp_path / "a.mat", which=1)
    assert found.names == ("torso", "leg", "rest")
    assert (found.labels == LABELS).all()
    with pytest.raises(FormatError, match=r"2 objects \(0 dog, 1 dog\)"):
        masks.read(tmp_path / "a.mat", which=2)


@pytest.mark.parametrize("data", [b"", b"MATLAB 5.0 MAT-file", b"\x00" * 300])
def test_a_damaged_mat_is_refused(tmp_path, data):
    (tmp_path / "a.mat").write_bytes(data)
    with pytest.raises(FormatError, match=r"a\.mat"):
        masks.read(tmp_path / "a.mat")


@pytest.mark.real
def test_real_pascal_part(real_data):
    found = masks.read(real_data("animal/pascal_part") / "2008_005643.mat")
    assert {"head", "torso"} <= set(found.names)
