"""Names of the files beside a model."""

from pathlib import Path

from ipcli.measurements.part_images import PartTree
from ipcli.stages.animal.output import file_word, side_files
from ipcli.stages.animal.parameters import ModelAnimal


def test_each_format_has_its_name_and_parts_have_theirs():
    tree = PartTree(("torso", "left ear"), (-1, 0))
    names = {path.name for path in side_files(Path("x/a.obj"), ModelAnimal(separate_parts="stl"), tree)}
    assert {"a.obj", "a.html", "a.turn.html", "a.torso.stl"} <= names
    assert len(names) == 5


def test_odd_names_of_parts_become_digests_that_differ():
    words = {file_word(name) for name in ("../x", "耳" * 40, "a b", "a_b", "a" * 200)}
    assert len(words) == 5
    assert all(word.isascii() and "/" not in word and len(word) < 70 for word in words)
