"""Checking a file."""

import pytest
import trimesh

from ipcli.errors import FormatError
from ipcli.stages.animal.check_mesh import check, told


def test_a_box_from_a_file(tmp_path):
    trimesh.creation.box((2, 2, 2)).export(tmp_path / "box.stl")
    facts = check(tmp_path / "box.stl")
    assert facts["watertight"]
    assert facts["volume"] == pytest.approx(8.0)
    assert str(told(facts)["volume"]) == "8 (in the mesh's own unit, cubed)"
    assert told(facts)["faces"] == 12


def test_no_mesh(tmp_path):
    with pytest.raises(FormatError):
        check(tmp_path / "none.ply")
