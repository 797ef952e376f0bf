"""The parameters of every command, and the configuration files that come with it, found by the table of commands."""

from pathlib import Path

import pytest

from ipcli import params
from ipcli.cli import main as cli

CONFIGS = Path(__file__).parent.parent / "configs"
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
