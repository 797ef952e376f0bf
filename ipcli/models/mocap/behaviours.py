"""The behaviours of an action in a group: the components of a Dirichlet process mixture of the group's features (5.8,
5.9).

chosen = draw_frames(actions, len(classes), settings, rng)             # at most 800 frames of each action
points = {group: Points(...)}                                          # their coordinates
fitted = {(action, group): learn(...)}                                 # each by itself: in any order, anywhere
model = assemble(...)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ipcli.errors import ParameterError
from ipcli.inverse.bayes import mixture
from ipcli.inverse.bayes.chain import TRACE
from ipcli.inverse.bayes.mixture import Fitted
from ipcli.inverse.bayes.predictive import Predictive
from ipcli.models.mocap import projection
from ipcli.models.mocap.parameters import BODY, MOTION, Learning
from ipcli.models.mocap.projection import Projection

LEAST_FRAMES = 2  # of an action that can be learnt


@dataclass(frozen=True, eq=False)
class Model:
    """What recognition needs: arrays alone."""

    actions: tuple[str, ...]
    groups: tuple[str, ...]
    projections: tuple[Projection, ...]  # of each group
    predictives: tuple[tuple[Predictive, ...], ...]  # of each action, of each group; of a person not learnt from
    alpha: np.ndarray  # (a, g), posterior mean of the concentration


def with_body(features: Mapping[str, np.ndarray], is_wanted: bool) -> dict[str, np.ndarray]:
    """The features of the groups, of the group of all groups: theirs side by side, and of motion if there are any."""
    found = {group: x for group, x in features.items() if group != MOTION}
    if is_wanted:
        found[BODY] = np.concatenate(list(found.values()), axis=1)
    if MOTION in features:
        found[MOTION] = features[MOTION]
    return found


def draw_frames(actions: np.ndarray, count: int, settings: Learning, rng: np.random.Generator) -> np.ndarray:
    """Indices, ascending, of at most `settings.frames` of the frames of each of `count` actions; actions (n,) int, -1:
    not to learn.

    Raises ParameterError for an action with hardly a frame.
    """
    chosen = []
    for action in range(count):
        rows = np.flatnonzero(actions == action)
        if len(rows) < LEAST_FRAMES:
            raise ParameterError(
                f"action number {action} has {len(rows)} frames to learn from: give at least {LEAST_FRAMES}, or leave "
                "it out"
            )
        chosen.append(rng.permutation(rows)[: settings.frames])
    return np.sort(np.concatenate(chosen))


def fit_projections(
    features: Mapping[str, np.ndarray], actions: np.ndarray, settings: Learning
) -> dict[str, Projection]:
    """The coordinates of each group, from features (n, D) of frames of actions (n,) int; frames with NaN in a group are
    left out of it.
    """
    found = {}
    for group, x in features.items():
        seen = np.isfinite(x).all(axis=1) & (actions >= 0)
        if not seen.any():
            raise ParameterError(
                f"group '{group}' is seen whole in no frame. Leave its missing joints out of the groups file"
            )
        found[group] = projection.fit(x[seen], actions[seen], group, settings.features)
    return found


def learn(
    x: np.ndarray,
    settings: Learning,
    rng: np.random.Generator,
    *,
    state: Mapping[str, np.ndarray] | None = None,
    watch: Callable[[dict[str, np.ndarray]], None] | None = None,
) -> Fitted:
    """The mixture of coordinates x (n, d) of one action in one group, rows with NaN left out.

    The hyperpriors measure by the coordinates' own unit about the action's mean, so that an action with few frames has
    a sound prior. `state` and `watch` are those of `mixture.fit`. Raises ParameterError when the group is hardly seen.
    """
    x = x[np.isfinite(x).all(axis=1)]
    if len(x) < LEAST_FRAMES:
        raise ParameterError(
            f"{len(x)} frames show the whole group: give at least {LEAST_FRAMES}, or leave the action or the group out"
        )
    return mixture.fit(
        x, settings.mixture, rng, mean=x.mean(axis=0), covariance=np.eye(x.shape[1]), state=state, watch=watch
    )


def of_others(predictive: Predictive, spread: float) -> Predictive:
    """The density for a person not learnt from: each component convolved with N(0, spread I), the offset of a person
    from others.
    """
    if spread == 0:
        return predictive
    scale = predictive.chol @ np.swapaxes(predictive.chol, 1, 2) + spread * np.eye(predictive.location.shape[1])
    return Predictive(
        predictive.log_weight, predictive.dof, predictive.location, np.linalg.cholesky(scale), predictive.draw
    )


def concentration(fitted: Fitted, settings: Learning) -> float:
    """Posterior mean of alpha over the kept sweeps of all chains."""
    return float(fitted.trace[:, settings.mixture.burn_in :, TRACE.index("alpha")].mean())


def assemble(
    actions: tuple[str, ...],
    projections: Mapping[str, Projection],
    fitted: Mapping[tuple[int, str], Fitted],
    settings: Learning,
) -> Model:
    """A model of what was learnt; `fitted` by number of the action and name of the group."""
    groups = tuple(projections)
    cells = [[fitted[action, group] for group in groups] for action in range(len(actions))]
    return Model(
        actions,
        groups,
        tuple(projections.values()),
        tuple(
            tuple(of_others(cell.predictive.thinned(settings.draws), settings.spread) for cell in row) for row in cells
        ),
        np.array([[concentration(cell, settings) for cell in row] for row in cells]),
    )


def train(
    features: Mapping[str, np.ndarray],
    actions: np.ndarray,
    names: tuple[str, ...],
    settings: Learning,
    rng: np.random.Generator,
) -> Model:
    """A model from features (n, D) of each group and actions (n,) int, indices of `names`, -1 where a frame is not to
    be learnt.
    """
    rows = draw_frames(actions, len(names), settings, rng)
    chosen = {group: x[rows] for group, x in with_body(features, settings.features.body).items()}
    projections = fit_projections(chosen, actions[rows], settings)
    fitted = {}
    for group, project in projections.items():
        points = project(chosen[group])
        for action in range(len(names)):
            fitted[action, group] = learn(points[actions[rows] == action], settings, rng.spawn(1)[0])
    return assemble(names, projections, fitted, settings)


def arrays(model: Model) -> dict[str, np.ndarray]:
    """The model as flat arrays; `of_arrays` is the inverse. Components of all cells stand one after the other, padded
    to the widest.
    """
    cells = [(a, g) for a in range(len(model.actions)) for g in range(len(model.groups))]
    parts = [model.predictives[a][g] for a, g in cells]
    counts = [len(part.dof) for part in parts]
    return {
        "actions": np.array(model.actions, np.str_),
        "groups": np.array(model.groups, np.str_),
        "alpha": model.alpha,
        "features": np.array([len(p.shift) for p in model.projections], np.int64),
        "dimensions": np.array([p.matrix.shape[1] for p in model.projections], np.int64),
        "shift": _padded([p.shift for p in model.projections]),
        "matrix": _padded([p.matrix for p in model.projections]),
        "component_action": np.repeat([a for a, _ in cells], counts),
        "component_group": np.repeat([g for _, g in cells], counts),
        "log_weight": np.concatenate([part.log_weight for part in parts]),
        "dof": np.concatenate([part.dof for part in parts]),
        "draw": np.concatenate([part.draw for part in parts]).astype(np.int32),
        "location": _padded([row for part in parts for row in part.location]),
        "chol": _padded([row for part in parts for row in part.chol]),
    }


def of_arrays(arrays: Mapping[str, Any]) -> Model:
    """The model that `arrays` describes."""
    actions, groups = (tuple(map(str, arrays[name])) for name in ("actions", "groups"))
    sizes = list(zip(arrays["features"], arrays["dimensions"], strict=True))
    projections = [
        Projection(arrays["shift"][g, :full], arrays["matrix"][g, :full, :d]) for g, (full, d) in enumerate(sizes)
    ]

    def cell(action: int, group: int) -> Predictive:
        rows, d = (arrays["component_action"] == action) & (arrays["component_group"] == group), sizes[group][1]
        log_weight, dof, draw = (arrays[name][rows] for name in ("log_weight", "dof", "draw"))
        return Predictive(log_weight, dof, arrays["location"][rows, :d], arrays["chol"][rows, :d, :d], draw)

    predictives = tuple(tuple(cell(a, g) for g in range(len(groups))) for a in range(len(actions)))
    return Model(actions, groups, tuple(projections), predictives, arrays["alpha"])


def _padded(parts: list[np.ndarray]) -> np.ndarray:
    """Arrays of unequal shape side by side, (n, *largest), 0 beyond each."""
    shape = np.max([part.shape for part in parts], axis=0)
    whole = np.zeros((len(parts), *shape))
    for place, part in zip(whole, parts, strict=True):
        place[tuple(slice(size) for size in part.shape)] = part
    return whole
