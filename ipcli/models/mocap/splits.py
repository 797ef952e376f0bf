"""Who is learnt from and who is asked. Which of these a figure belongs to decides what it says, so it is never left
out.

Frames of a take lie 8 ms apart. The thesis draws its training frames at random, which puts neighbours on both sides: a
near-copy of every question has been learnt. Other clips of the same people are easier than other people.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.errors import ParameterError, nearest
from ipcli.models.mocap.parameters import SPLIT_KINDS

KINDS = SPLIT_KINDS
PARTING = ("subjects", "leave-one-out", "one-to-rest")  # the kinds that part people
MOST_FRAMES = 800  # of an action, drawn at random (thesis 5.5)


@dataclass(frozen=True, eq=False)
class Split:
    """Frames to learn from and frames to ask about."""

    name: str
    train: np.ndarray  # (n,) bool
    test: np.ndarray  # (n,) bool


@dataclass(frozen=True, eq=False)
class Frames:
    """Where the frames of a set of clips come from."""

    clip: np.ndarray  # (n,) int, of each frame
    label: np.ndarray  # (c,) str, of each clip
    actor: np.ndarray  # (c,) str, of each clip
    action: np.ndarray | None = None  # (n,) str, of each frame, where that is not the label of its clip


def make(
    kind: str,
    frames: Frames,
    rng: np.random.Generator,
    *,
    test: Sequence[str] = (),
    published: Mapping[str, np.ndarray] | None = None,
) -> list[Split]:
    """The splits of a kind, one of KINDS.

    `test`: the actors to ask about, of kind `subjects`. `published`: entries (c,) 1 train, 2 test, 0 neither, by name.
    Raises ParameterError for an unknown kind or actor, or when a split has nothing on one side.
    """
    if kind not in KINDS:
        raise ParameterError(f"unknown split '{kind}'{nearest(kind, KINDS)} Known: {', '.join(KINDS)}")
    if kind in PARTING and not (frames.actor != "").any():
        raise ParameterError(
            f"the clips do not say who moves, and split '{kind}' parts people. Name them by folders LABEL/ACTOR/ or by "
            "a manifest, or give --split clips"
        )
    if kind in PARTING and len(np.unique(frames.actor)) == 1:
        raise ParameterError(
            f"all clips are of '{frames.actor[0]}', and split '{kind}' parts people. Give more, or --split clips"
        )
    found = {
        "frames": lambda: [random_frames(frames, rng)],
        "clips": lambda: [random_clips(frames, rng)],
        "subjects": lambda: [actors(frames, test)],
        "leave-one-out": lambda: leave_one_actor_out(frames),
        "one-to-rest": lambda: one_actor(frames),
        "published": lambda: of_published(frames, published or {}),
    }[kind]()
    for split in found:
        if not (split.train.any() and split.test.any()):
            side = "test on" if split.train.any() else "train on"
            raise ParameterError(
                f"split '{split.name}' ({kind}) has nothing to {side}. Choose another kind, or give more clips or "
                "actors"
            )
    return found


def random_frames(frames: Frames, rng: np.random.Generator) -> Split:
    """As in the thesis: of each action 800 frames at random, at most half of them; all others are test. It leaks."""
    action = frames.label[frames.clip] if frames.action is None else frames.action
    train = np.zeros(len(action), bool)
    for name in np.unique(action):
        rows = np.flatnonzero(action == name)
        train[rng.permutation(rows)[: min(MOST_FRAMES, len(rows) // 2)]] = True
    return Split("random frames", train, ~train)


def random_clips(frames: Frames, rng: np.random.Generator) -> Split:
    """Half of the clips of each action, of whichever actor; an action of one clip is learnt."""
    train = np.zeros(len(frames.label), bool)
    for name in np.unique(frames.label):
        rows = np.flatnonzero(frames.label == name)
        train[rng.permutation(rows)[: -(-len(rows) // 2)]] = True
    return _of_clips("random clips", frames, train, ~train)


def actors(frames: Frames, test: Sequence[str]) -> Split:
    """All clips of the actors named `test` against all others."""
    known = tuple(np.unique(frames.actor))
    for name in test:
        if name not in known:
            raise ParameterError(f"no actor '{name}'{nearest(name, known)} Known: {', '.join(known)}")
    asked = np.isin(frames.actor, list(test))
    return _of_clips(f"test on {', '.join(test)}", frames, ~asked, asked)


def leave_one_actor_out(frames: Frames) -> list[Split]:
    """Each actor in turn is asked, all others are learnt from."""
    return [
        _of_clips(f"test on {name}", frames, frames.actor != name, frames.actor == name)
        for name in np.unique(frames.actor)
    ]


def one_actor(frames: Frames) -> list[Split]:
    """Each actor in turn is learnt from, all others are asked."""
    return [
        _of_clips(f"train on {name}", frames, frames.actor == name, frames.actor != name)
        for name in np.unique(frames.actor)
    ]


def of_published(frames: Frames, published: Mapping[str, np.ndarray]) -> list[Split]:
    """The splits that came with the data."""
    if not published:
        raise ParameterError("these clips come with no published splits. Choose another kind of split")
    return [_of_clips(name, frames, entries == 1, entries == 2) for name, entries in published.items()]


def _of_clips(name: str, frames: Frames, train: np.ndarray, test: np.ndarray) -> Split:
    return Split(name, train[frames.clip], test[frames.clip])
