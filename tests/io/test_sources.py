"""Sources are opened by the first layout that knows them or by name, and hints go to those that take them."""

import os
from pathlib import Path

import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.sources import Layout, open_source
from tests.fixtures.errors import check_message


def opened_as(name):
    def plain(path):
        return name, path, {}

    def scaled(path, *, unit=None, scale=1.0):
        return name, path, {"unit": unit, "scale": scale}

    return scaled if name == "scaled" else plain


LAYOUTS = {
    "scaled": Layout(lambda path: path.suffix == ".s", opened_as("scaled"), "a file with a scale"),
    "folder": Layout(lambda path: path.is_dir(), opened_as("folder"), "a folder"),
    "any": Layout(lambda path: path.suffix != ".no", opened_as("any"), "any file"),
}


def opened(path, *args, **hints):
    return open_source(path, LAYOUTS, "things", "See the manual", *args, **hints)


@pytest.fixture
def place(tmp_path):
    for name in ("a.s", "a.x", "a.no"):
        (tmp_path / name).touch()
    return tmp_path


def refused(error, call, *mentioned):
    with pytest.raises(error) as raised:
        call()
    check_message(raised.value, *mentioned)


def test_the_first_layout_that_knows_the_source_opens_it(place):
    assert opened(place / "a.s")[0] == "scaled"
    assert opened(place)[0] == "folder"
    assert opened(str(place / "a.x"))[:2] == ("any", place / "a.x")


def test_a_format_by_name_is_not_asked_whether_it_knows_the_source(place):
    assert opened(place / "a.no", "folder")[0] == "folder"
    assert opened(place / "a.s", "any")[0] == "any"


def test_layouts_after_the_one_that_fits_are_not_asked(place):
    asked = []
    layouts = {
        name: Layout(lambda path, name=name: asked.append(name) or name == "second", opened_as(name), name)
        for name in ("first", "second", "third")
    }
    assert open_source(place, layouts, "things", "")[0] == "second"
    assert asked == ["first", "second"]


def test_hints_reach_the_layout_and_none_is_no_hint(place):
    assert opened(place / "a.s", unit="m", scale=None) == ("scaled", place / "a.s", {"unit": "m", "scale": 1.0})
    assert opened(place / "a.s", scale=0.0)[2] == {"unit": None, "scale": 0.0}
    assert opened(place, unit=None, colour=None)[2] == {}


def test_a_hint_without_use_is_refused_with_those_that_have_one(place):
    refused(ParameterError, lambda: opened(place / "a.s", colour=1), "a.s: 'colour'", "that takes unit, scale")
    refused(ParameterError, lambda: opened(place, unit="m"), "'unit' means nothing to a folder; that takes no hints")
    # The path itself is no hint, though the function that opens has a parameter of that name.
    refused(ParameterError, lambda: opened(place, "folder", self=1), "'self'")


def test_what_nothing_knows_is_refused_with_all_that_was_looked_for(place):
    refused(
        FormatError,
        lambda: opened(place / "a.no"),
        "a.no: no known layout of things",
        "Looked for scaled: a file with a scale; folder: a folder; any: any file",
        "See the manual",
    )
    refused(FormatError, lambda: opened(place / "none.s"), "none.s: no such file or folder")
    refused(FormatError, lambda: opened(place / "none.s", "scaled"), "none.s: no such file or folder")


def test_an_unknown_format_is_answered_by_the_nearest(place):
    refused(ParameterError, lambda: opened(place, "foldre"), "'foldre'; did you mean 'folder'? Known: auto, scaled")


@pytest.mark.parametrize("format", ["auto", "any"])
def test_pipes_and_devices_are_refused_before_anything_waits_for_them(tmp_path, format):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        refused(FormatError, lambda path=path: opened(path, format), str(path), "pipe or a device")
