"""The parameters of every command, and the configuration files that come with it, found by the table of commands."""

import tomllib
from pathlib import Path

import pytest

from ipcli import params
from ipcli.cli import main as cli
from ipcli.errors import ParameterError
from tests.fixtures.house import PACKAGE, ROOT

CONFIGS = PACKAGE / "configs"
CLASSES = {
    name: cls for name in cli.COMMANDS if (cls := getattr(cli.load(name).callback, "parameters", None)) is not None
}


def test_the_table_leads_to_the_parameters_of_commands():
    assert {"fuse-depth", "mocap-train"} <= set(CLASSES)


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*/*.toml")), ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_configuration_file_is_understood_and_changes_something(path):
    cls = CLASSES[path.parent.name]
    resolved = params.resolve(cls, config=path, env={}, sets=(), flags={})
    assert params.as_dict(resolved) != params.as_dict(cls())


@pytest.mark.parametrize("name", CLASSES)
def test_parameters_have_defaults_that_are_allowed_and_a_key_a_setting(name):
    cls = CLASSES[name]
    keys = [leaf.key for leaf in params.leaves(cls)]
    assert len(set(keys)) == len(keys)
    assert params.resolve(cls, env={}, sets=(), flags={}) == cls()


def test_all_files_of_the_package_are_in_the_wheel():
    """setuptools takes modules by itself, and of other files those that pyproject.toml names."""
    built = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    named = {
        path
        for package, patterns in built["package-data"].items()
        for pattern in patterns
        for path in ROOT.joinpath(*package.split(".")).glob(pattern)
    }
    others = {p for p in PACKAGE.rglob("*") if p.is_file() and p.suffix != ".py" and "__pycache__" not in p.parts}
    assert set(CONFIGS.glob("*/*.toml")) <= named
    assert others <= named


@pytest.mark.parametrize(
    ("given", "command", "file"),
    [
        ("kitti", "fuse-depth", "fuse-depth/kitti.toml"),
        ("thesis", "fuse-depth", "fuse-depth/thesis.toml"),
        ("thesis", "mocap-train", "mocap-train/thesis.toml"),
        ("mocap-train/thesis", "mocap-evaluate", "mocap-train/thesis.toml"),
    ],
)
def test_a_shipped_configuration_is_found_by_its_name(given, command, file):
    assert params.find_config(Path(given), command) == CONFIGS / file


def test_a_file_comes_before_a_shipped_configuration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "kitti").write_text("")
    (tmp_path / "quick").mkdir()
    assert params.find_config(Path("kitti"), "fuse-depth") == Path("kitti")
    assert params.find_config(Path("quick"), "fuse-depth") == CONFIGS / "fuse-depth/quick.toml"
    assert params.find_config(Path("mine.toml"), "fuse-depth") == Path("mine.toml")


def test_an_unknown_name_is_answered_by_what_is_shipped(capsys):
    with pytest.raises(ParameterError) as error:
        params.find_config(Path("kity"), "fuse-depth")
    assert "did you mean 'kitti'? Shipped: kitti, quick, thesis, mocap-train/thesis" in str(error.value)
    assert cli.main(["mocap-evaluate", "x", "-o", "y.h5", "--config", "thesis"]) == 2
    assert "Shipped: fuse-depth/kitti, fuse-depth/quick" in capsys.readouterr().err
