"""What is refused before it is opened, and settings that parsers take ill."""

import os
from pathlib import Path

import pytest

from ipcli import inputs, params, provenance
from ipcli.cli import main as cli
from ipcli.errors import FormatError, IpcliError
from ipcli.io.files import h5, images, npz, ply, text
from ipcli.io.motion import groups
from ipcli.io.parts import project
from ipcli.io.views import camera
from ipcli.stages.brdf import materials
from ipcli.stages.fusion.parameters import FuseDepth

READERS = {
    "digest": provenance.sha256,
    "h5": h5.peek,
    "npz": npz.read,
    "ply": ply.read,
    "depth": lambda path: images.read_depth(path.with_suffix(".npy")),
    "image": images.read_image,
    "text": text.read_text,
    "old text": text.read_any_text,
}
SETTINGS = {
    "camera": camera.read,
    "groups": groups.read,
    "project": project.read,
    "materials": materials.read,
    "toml": inputs.read_toml,
}


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    """A pipe, under each name that a reader asks for: opening it would wait for a writer that never comes."""
    path = tmp_path_factory.mktemp("pipes") / "pipe"
    os.mkfifo(path)
    path.with_suffix(".npy").symlink_to(path)
    return path


@pytest.mark.timeout(20)
@pytest.mark.parametrize("reader", [*READERS.values(), *SETTINGS.values()], ids=[*READERS, *SETTINGS])
def test_a_pipe_or_an_impossible_name_is_refused_before_it_is_opened(pipe, reader):
    with pytest.raises(FormatError, match="a pipe or a device"):
        reader(pipe)
    with pytest.raises(IpcliError, match=r"no name of a file|no such file|cannot be read"):
        reader(pipe.with_name("a\0b"))


@pytest.mark.timeout(20)
def test_a_configuration_that_is_a_device_is_wrong_usage(capsys, tmp_path):
    line = ["fuse-depth", str(tmp_path), "-o", str(tmp_path / "x.h5"), "--config"]
    assert cli.main([*line, "/dev/zero"]) == 2
    assert "a pipe or a device" in capsys.readouterr().err


def test_files_folders_and_what_is_not_there_pass(tmp_path):
    (tmp_path / "a").write_text("")
    for path in (tmp_path, tmp_path / "a", tmp_path / "none"):
        assert inputs.check_file(path) == path


ILL = {
    "digits": "a = " + "9" * 5000,
    "beyond": "a = [{ b = 1" + "0" * 400 + " }]",
    "deep": "a = " + "[" * 5000 + "]" * 5000,
    "dotted": ".".join("a" * 5000) + " = 1",
    "latin": "a = '\xe9'".encode("latin-1"),
    "cut": "[a",
}


@pytest.mark.parametrize("ill", ILL.values(), ids=ILL)
@pytest.mark.parametrize("read", SETTINGS.values(), ids=SETTINGS)
def test_settings_that_a_parser_takes_ill_are_a_fault_of_the_file(tmp_path, read, ill):
    path = tmp_path / "s.toml"
    path.write_bytes(ill if isinstance(ill, bytes) else ill.encode())
    if read is inputs.read_toml and ill is ILL["dotted"]:
        assert list(read(path)) == ["a"]
        return
    with pytest.raises(FormatError, match=r"s\.toml"):
        read(path)
    with pytest.raises(params.ParameterError, match=r"s\.toml"):
        params.resolve(FuseDepth, config=path)


@pytest.mark.parametrize(("told", "what"), [("[" * 9999, "too deep"), ("[1]", "object"), ("9" * 5000, "object")])
def test_json_that_is_no_object_is_refused(tmp_path, told, what):
    path = tmp_path / "s.json"
    path.write_text(told)
    with pytest.raises(FormatError, match=what):
        inputs.read_json(path)


def test_whole_numbers_of_json_that_no_float_holds_are_infinite():
    found = inputs.json_of('{"a": [1, 900719925474099, 1' + "0" * 20 + ", -1" + "0" * 400 + "]}")
    assert found == {"a": [1, 900719925474099, 1e20, -float("inf")]}
    with pytest.raises(ValueError, match="too deep"):
        inputs.json_of("[" * 9999)


def test_settings_of_gigabytes_are_not_read(tmp_path):
    with (tmp_path / "s.toml").open("wb") as file:
        file.truncate(1 << 34)
    with pytest.raises(FormatError, match="too large"):
        inputs.read_toml(tmp_path / "s.toml")


def test_a_picture_given_as_settings_is_told_to_be_one(tmp_path):
    (tmp_path / "s.toml").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    with pytest.raises(FormatError, match="binary file such as a picture"):
        inputs.read_toml(tmp_path / "s.toml")


def test_a_byte_order_mark_is_no_key(tmp_path):
    Path(tmp_path / "s.toml").write_bytes(b"\xef\xbb\xbfa = 1\n")
    assert inputs.read_toml(tmp_path / "s.toml") == {"a": 1}


def test_a_number_at_the_very_end_may_be_cut():
    ends = ("1 2\n3 10", "1.", "1 2\n", "", "a}")
    assert [inputs.cut_number(end) for end in ends] == [True, True, False, False, False]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", None),
        ("1 2\n", None),
        ("1 2\r", None),
        ("1 2", "its last number may be cut"),
        ("a,b", "more may be missing"),
    ],
)
def test_a_list_whose_last_line_has_no_end_is_said_to_be_perhaps_cut(tmp_path, caplog, content, said):
    inputs.warn_if_cut(tmp_path / "a.txt", content)
    assert [said in record.message and "a.txt" in record.message for record in caplog.records] == [True] * bool(said)


@pytest.mark.parametrize(("content", "count"), [("scale = 10", 1), ("scale = 10\n", 0), ('unit = "m"', 0)])
def test_settings_that_end_within_a_number_are_said_to_be_perhaps_cut(tmp_path, caplog, content, count):
    (tmp_path / "a.toml").write_text(content)
    inputs.read_toml(tmp_path / "a.toml")
    assert len(caplog.records) == count
