"""The configuration files that come with ipcli."""

from pathlib import Path

import pytest

from ipcli import params
from ipcli.stages.fusion import fuse_depth
from ipcli.stages.mocap.parameters import MocapTrain

CONFIGS = Path(__file__).parent.parent / "configs"
CLASSES = {"fuse-depth": fuse_depth.Params, "mocap-train": MocapTrain}


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*/*.toml")), ids=lambda path: path.stem)
def test_every_configuration_file_is_understood_and_changes_something(path):
    cls = CLASSES[path.parent.name]
    resolved = params.resolve(cls, config=path, env={}, sets=(), flags={})
    assert params.as_dict(resolved) != params.as_dict(cls())
