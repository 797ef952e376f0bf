"""How well "none of these" works: an action is left out of what is learnt, and its clips by others are asked about.

Everything is learnt anew without the action, the coordinates and the calibration too. Its clips should be none of the
actions, and the clips of all others should not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipcli.errors import ParameterError
from ipcli.models.mocap import open_set, recognition
from ipcli.models.mocap.calibration import threshold
from ipcli.models.mocap.motions import Motions, number_actions
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.splits import Split
from ipcli.models.mocap.training import Fit, LearntBehaviours, learn

LEAST_ACTIONS = 3  # one left out, and two to tell apart


def evaluate_left_out(
    known: Motions,
    split: Split,
    learning: Learning,
    decision: Decision,
    seed: int,
    fit: Fit | None = None,
) -> dict[str, np.ndarray]:
    """Leave each action out in turn; answers as arrays of the `action-novelty` artefact. `fit` as of `learn`.

    Raises ParameterError for fewer than LEAST_ACTIONS actions, or where one is not on both sides of the split.
    """
    names = number_actions(known.labels)[0]
    if len(names) < LEAST_ACTIONS:
        raise ParameterError(
            f"{len(names)} actions have labels; to leave one out give clips of at least {LEAST_ACTIONS}"
        )
    train, test = (_clips(known, rows) for rows in (split.train, split.test))
    tables = []
    for action in names:
        learnt = learn(without(train, action), learning, decision, seed, fit, f"without {action}: ")
        tables.append(_ask(learnt, test, action, learning, decision))
    found = {key: np.concatenate([table[key] for table in tables]) for key in tables[0]} | {
        "threshold": np.array(threshold(decision)),
        "left_out": np.array(names, np.str_),
        "query_left_out": np.repeat(np.arange(len(names)), [len(table["clips"]) for table in tables]),
        "people": np.array(split.name),
    }
    return found | open_set.figures(found)


def _clips(known: Motions, rows: np.ndarray) -> Motions:
    """The clips that have any of the frames (n,) bool, with the labels of those alone."""
    starts, found = np.cumsum([0, *known.lengths]), []
    for clip, start, end in zip(known.clips, starts[:-1], starts[1:], strict=True):
        if rows[start:end].any():
            labels = clip.frame_labels
            kept = None if labels is None else np.where(rows[start:end], labels, "")
            found.append(replace(clip, frame_labels=kept))
    return Motions(tuple(found), known.groups)


def without(motions: Motions, action: str) -> Motions:
    """The clips but those of an action; in takes of several its frames have no label."""
    found = []
    for clip in motions.clips:
        if clip.frame_labels is not None:
            found.append(replace(clip, frame_labels=np.where(clip.frame_labels == action, "", clip.frame_labels)))
        elif clip.label != action:
            found.append(clip)
    return replace(motions, clips=tuple(found))


def _ask(
    learnt: LearntBehaviours, test: Motions, action: str, learning: Learning, decision: Decision
) -> dict[str, np.ndarray]:
    """The answers to each labelled clip, one of several actions as a clip for each."""
    names, numbers = number_actions(test.labels)
    rows = np.flatnonzero(numbers >= 0)
    keys, query = np.unique(test.clip[rows] * len(names) + numbers[rows], return_inverse=True)
    features = test.features(learnt.lengths, learning.features)
    own = {group: x[rows] for group, x in features.items()}
    density = recognition.log_densities(learnt.model, own)
    posterior = recognition.frame_posteriors(learnt.model, density, decision)
    surprise = recognition.novelty_scores(learnt.model, density)
    told, judges = recognition.answer(posterior, surprise, query, len(keys), decision), learnt.judges
    if True not in judges.references:
        raise ParameterError(
            f"without '{action}' there is nothing to calibrate on: every action that is learnt must be shown by at "
            "least two people (or in two clips of a single one)"
        )
    asked = judges.measured(judges.log_densities(own), query, len(keys), decision, ordered=True)
    return {
        "clips": np.array([test.clips[key // len(names)].name for key in keys], np.str_),
        "truth": np.array([names[key % len(names)] for key in keys], np.str_),
        "best": np.array(learnt.model.actions, np.str_)[told.posterior.argmax(axis=1)],
        "posterior": told.posterior.max(axis=1),
        "novelty": judges.references[True].novelty(asked),
        "surprise": told.novelty,
    }
