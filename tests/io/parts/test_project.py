"""Projects: what they hold, and what is wrong with them in words."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import images
from ipcli.io.parts import project
from ipcli.measurements.part_images import PartTree

PARTS = '[parts]\ntorso = ""\nhead = "torso"\n'
IMAGE = '[[images]]\nmasks = "a.png"\nview = "left"\n'


def written(folder, text):
    labels = np.zeros((20, 30), np.uint8)
    labels[3:12, 3:20], labels[3:8, 20:26] = 1, 2
    images.write_png(folder / "a.png", labels)
    path = folder / "p.toml"
    path.write_text(text)
    return path


def test_a_whole_project(tmp_path):
    text = (
        'name = "ox"\nsize = 2\n'
        + PARTS
        + "[flatness]\nhead = 1.5\n"
        + IMAGE
        + 'aspects = ["head"]\npose = "reference"\n'
    )
    found = project.read(written(tmp_path, text))
    assert (found.name, found.size) == ("ox", 2.0)
    assert found.tree == PartTree(("torso", "head"), (-1, 0), (1.0, 1.5))
    (image,) = found.images
    assert (image.view, image.aspects, image.is_reference) == ("left", (1,), True)
    assert found.files == (tmp_path / "p.toml", tmp_path / "a.png")


def test_a_view_may_be_given_by_its_angles(tmp_path):
    (image,) = project.read(written(tmp_path, PARTS + IMAGE.replace('"left"', "[40, 15.5]"))).images
    assert image.view == "40,15.5"


@pytest.mark.parametrize(
    "angles", ["[nan, 5]", "[inf, 0]", '["40", "15"]', "[true, false]", "[40]", "[1, 2, 3]", "[0, 91]"]
)
def test_what_are_no_angles_of_a_view_is_refused(tmp_path, angles):
    with pytest.raises(FormatError, match="azimuth"):
        project.read(written(tmp_path, PARTS + IMAGE.replace('"left"', angles)))


def test_names_are_translated_and_dropped(tmp_path):
    text = '[parts]\nbody = ""\n' + IMAGE + 'labels = ["torso", "head"]\nrename = { torso = "body", head = "" }\n'
    (image,) = project.read(written(tmp_path, text)).images
    assert set(np.unique(image.labels)) == {0, 1}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no parts"),
        (PARTS, "no images"),
        ("part = 1\n" + PARTS + IMAGE, "unknown key 'part'"),
        ('[parts]\ntorso = ""\nhead = "torzo"\n' + IMAGE, "did you mean 'torso'"),
        ('[parts]\ntorso = ""\nhead = ""\n' + IMAGE, "one root"),
        ('[parts]\ntorso = ""\na = "b"\nb = "a"\n' + IMAGE, "circle"),
        (PARTS + '[[images]]\nview = "left"\n', "no masks"),
        (PARTS + '[[images]]\nmasks = "b.png"\n', "b.png"),
        (PARTS + IMAGE.replace("left", "lift"), "did you mean 'left'"),
        (PARTS + IMAGE.replace('"left"', "[40]"), "azimuth .* and elevation"),
        (PARTS + IMAGE.replace('"left"', "[40, 120]"), "azimuth .* and elevation"),
        (PARTS + IMAGE + IMAGE, "two images"),
        (PARTS + IMAGE + 'pose = "other"\n', "reference pose"),
        (PARTS + IMAGE + 'aspects = ["tail"]\n', "unknown part 'tail'"),
        (PARTS + "[flatness]\nhead = 0\n" + IMAGE, "flatness"),
        ("size = -1\n" + PARTS + IMAGE, "size"),
        ("size = true\n" + PARTS + IMAGE, "size"),
        ('[parts]\ntorso = ""\n' + IMAGE + 'labels = ["torso", "horn"]\n', "unknown part 'horn'"),
        ("x = [" * 3000, "TOML"),
        ("size = 1" + "0" * 400 + "\n" + PARTS + IMAGE, "more than 64 bits"),
        (PARTS + IMAGE.replace("a.png", "x" * 5000), "no such file"),
    ],
)
def test_errors_name_the_file_and_the_part(tmp_path, text, words):
    with pytest.raises(FormatError, match=words):
        project.read(written(tmp_path, text))


def test_a_project_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(FormatError, match="cannot be read"):
        project.read(tmp_path / "none.toml")
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="not a readable text file"):
        project.read(tmp_path / "b.toml")


def test_all_unknown_parts_are_named_at_once(tmp_path):
    path = written(tmp_path, '[parts]\ntorso = ""\n' + IMAGE + 'labels = ["horn", "hoof"]\n')
    with pytest.raises(FormatError, match="unknown parts 'horn', 'hoof'") as told:
        project.read(path)
    assert '"horn" = "PART", "hoof" = "PART"' in str(told.value)


MATCHES = (
    '[[matches]]\npart = "head"\nimages = ["a", "b"]\n'
    "points = [[1, 2, 3, 4], [5, 6, 7, 8], [9, 8, 7, 6], [1, 1, 1, 1]]\n"
)


def test_matches_of_two_images(tmp_path):
    two = PARTS + IMAGE + IMAGE.replace('view = "left"', 'name = "b"')
    (found,) = project.read(written(tmp_path, two + MATCHES)).matches
    assert (found.part, found.images) == (1, ("a", "b"))
    assert found.points[1].tolist() == [[5, 6], [7, 8]]
    for old, new, words in (('"head"', '"haed"', "did you mean 'head'"), ('"b"]', '"c"]', "two images of a, b"),
                            (", [1, 1, 1, 1]", "", "4 or more"), ("[1, 1, 1, 1]", "[9, 8, 7, 6]", "4 or more"),
                            ('["a", "b"]', '[["a"], ["b"]]', "two images"), ("[1, 1, 1, 1]", "[1, 1]", "row] each"),
                            ("[1, 1, 1, 1]", "[1, nan, 1, 1]", "within both"), ("[9, 8, 7, 6]", "[9, 8, 7, 60]", "60"),
                            ("[[1, 2, 3, 4]", "[[1, 2, 3], [4, 1, 2]", "each")):  # fmt: skip
        with pytest.raises(FormatError, match=words):
            project.read(written(tmp_path, two + MATCHES.replace(old, new)))
