"""PASCAL-Part annotations, sound and damaged."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.parts import masks, pascal, project

LABELS = np.zeros((20, 30), np.uint8)
LABELS[2:10, 3:20] = 1
LABELS[10:18, 5:9] = 2


def pascal_file(path, classes=("cat", "dog"), rest=0):
    from scipy.io import savemat

    def part(name, number):
        return {"part_name": name, "mask": (number == LABELS).astype(np.uint8)}

    whole = (LABELS > 0).astype(np.uint8)
    whole[2:10, 20 : 20 + rest] = 1
    thing = {"class": "dog", "mask": whole, "parts": [part("torso", 1), part("leg", 2)]}
    savemat(path, {"anno": {"imname": "x", "objects": [{**thing, "class": name} for name in classes]}})


def test_pascal_part(tmp_path):
    pascal_file(tmp_path / "a.mat")
    found = masks.read(tmp_path / "a.mat", which=1)
    assert found.names == ("torso", "leg", "rest")
    assert (found.labels == LABELS).all()


def test_an_object_that_is_not_there(tmp_path):
    pascal_file(tmp_path / "a.mat")
    for which in (2, -1):
        with pytest.raises(FormatError, match=rf"no object {which}; it holds 0 cat, 1 dog\. Objects count from 0"):
            masks.read(tmp_path / "a.mat", which=which)


def test_objects_are_listed(tmp_path):
    pascal_file(tmp_path / "a.mat", ["person", "horse"])
    assert pascal.objects(tmp_path / "a.mat") == ("person", "horse")
    assert pascal.counted(["cow"] * 22).endswith("19 cow and 2 more")


def test_unknown_parts_are_told_with_the_object_that_has_them(tmp_path):
    pascal_file(tmp_path / "a.mat", ["person", "horse"], rest=4)
    (tmp_path / "p.toml").write_text('[parts]\nbelly = ""\n[[images]]\nmasks = "a.mat"\nview = "left"\n')
    with pytest.raises(FormatError) as told:
        project.read(tmp_path / "p.toml")
    text = str(told.value)
    assert "'torso', 'leg', 'rest' of object 0, a person (the file holds 0 person, 1 horse;" in text
    assert '{ "torso" = "PART", "leg" = "PART", "rest" = "belly" }' in text
    assert "'rest' is what no part of the object covers, mostly belly" in text


def test_what_a_project_leaves_out_is_counted(tmp_path):
    pascal_file(tmp_path / "a.mat", ["horse"], rest=4)
    rename = 'rename = { "torso" = "belly", "leg" = "belly", "rest" = "" }'
    text = f'[parts]\nbelly = ""\n[[images]]\nmasks = "a.mat"\nview = "left"\n{rename}\n'
    (tmp_path / "p.toml").write_text(text)
    (image,) = project.read(tmp_path / "p.toml").images
    assert image.dropped == {"rest": 8 * 4}
    assert image.silhouette.sum() == (LABELS > 0).sum()


@pytest.mark.parametrize("data", [b"", b"MATLAB 5.0 MAT-file", b"\x00" * 300])
def test_a_damaged_mat_is_refused(tmp_path, data):
    (tmp_path / "a.mat").write_bytes(data)
    with pytest.raises(FormatError, match=r"a\.mat"):
        masks.read(tmp_path / "a.mat")


@pytest.mark.real
def test_real_pascal_part(real_data):
    found = masks.read(real_data("animal/pascal_part") / "2008_005643.mat")
    assert {"head", "torso"} <= set(found.names)
