"""Labelled clips of the generated bodies as files, for the tests of the mocap commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.geometry.skeleton import Clip
from ipcli.io import clips as io
from ipcli.io import h5
from tests.mocap_bodies import ACTIONS, GROUPS, acted

ACTORS = ("ann", "bob", "cyd", "dan")
QUICK = (
    "--frames",
    "60",
    "--set",
    "learning.mixture.sweeps=8",
    "--set",
    "learning.mixture.burn_in=4",
    "--set",
    "learning.mixture.thin=2",
)


def clip(action: str, actor: int, frames: int = 24, repeat: int = 0) -> Clip:
    """One person does one thing."""
    return Clip(f"{action}_{ACTORS[actor]}_{repeat}", acted(action, frames, 10 * repeat + actor), action, ACTORS[actor])


def every(frames: int = 24, repeats: int = 2) -> list[Clip]:
    """All people do all things so often."""
    return [
        clip(action, actor, frames, n) for action in ACTIONS for actor in range(len(ACTORS)) for n in range(repeats)
    ]


def take() -> Clip:
    """One after the other, with labels frame by frame."""
    parts = [acted(action, 45, 7) for action in ACTIONS]
    motion = parts[0]
    for name in ("positions", "rotations"):
        object.__setattr__(motion, name, np.concatenate([getattr(part, name) for part in parts]))
    return Clip("take", motion, "", "eve", np.repeat(list(ACTIONS), 45))


def write(path: Path, clips: list[Clip]) -> Path:
    """A clips artefact, two splits by people with it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    actor = np.array([ACTORS.index(one.actor) if one.actor in ACTORS else 0 for one in clips])
    splits = {"first": np.where(actor < 2, 1, 2), "second": np.where(actor % 2, 1, 2)}
    h5.write(path, "clips", io.artefact(clips, splits), {})
    return path


def write_groups(path: Path) -> Path:
    """The groups of the generated bodies as a TOML file."""
    lists = [f"{key} = {list(getattr(GROUPS, key))!r}" for key in ("left", "right", "bottom")]
    names = [f"{key} = {getattr(GROUPS, key)!r}" for key in ("root", "top")]
    parts = [f"{part} = {list(joints)!r}" for part, joints in GROUPS.parts.items()]
    path.write_text("\n".join([*names, *lists, "[groups]", *parts]) + "\n", encoding="utf-8")
    return path
