"""The behaviours of an action in a group: the components of a Dirichlet process mixture of the group's features (5.8,
5.9).

rows = draw_frames(actions, names, settings, rng)                      # at most 800 frames of each action
projections = fit_projections(features, actions, settings)             # coordinates of each group
fitted = {(action, group): learn(...)}                                 # each by itself: in any order, anywhere
model = assemble(names, projections, fitted, settings)

`training` does all of this.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.skeleton import Groups, Skeleton
from ipcli.inverse.bayes import mixture
from ipcli.inverse.bayes.chain import TRACE
from ipcli.inverse.bayes.mixture import Fitted
from ipcli.inverse.bayes.predictive import Predictive
from ipcli.models.mocap import projection
from ipcli.models.mocap.parameters import BODY, MOTION, Learning
from ipcli.models.mocap.projection import Projection

LEAST_FRAMES = 2  # of an action that can be learnt
PER_COMPONENT = ("component_action", "component_group", "log_weight", "dof", "draw")  # arrays of numbers of components
SHAPES = ("location", "chol")  # where components are and how wide


@dataclass(frozen=True, eq=False)
class Model:
    """What recognition needs: arrays alone."""

    actions: tuple[str, ...]
    groups: tuple[str, ...]
    projections: tuple[Projection, ...]  # of each group
    predictives: tuple[tuple[Predictive, ...], ...]  # of each action, of each group; of a person not learnt from
    alpha: np.ndarray  # (a, g), posterior mean of the concentration


class Body(NamedTuple):
    """Whose motions a model understands."""

    skeleton: Skeleton
    groups: Groups
    lengths: np.ndarray  # (j,), bones of the common skeleton of height 1


def with_body(features: Mapping[str, np.ndarray], is_wanted: bool) -> dict[str, np.ndarray]:
    """The features of the groups, of the group of all groups: theirs side by side, and of motion if there are any."""
    found = {group: x for group, x in features.items() if group != MOTION}
    if is_wanted:
        found[BODY] = np.concatenate(list(found.values()), axis=1)
    if MOTION in features:
        found[MOTION] = features[MOTION]
    return found


def draw_frames(actions: np.ndarray, names: Sequence[str], settings: Learning, rng: np.random.Generator) -> np.ndarray:
    """Draw at most `settings.frames` of the frames of each action; their indices, ascending.

    `actions` (n,) int, indices of `names`, -1: not to learn. Raises ParameterError for an action with hardly a frame.
    """
    counts = [int((actions == action).sum()) for action in range(len(names))]
    for name, count in zip(names, counts, strict=True):
        if count < LEAST_FRAMES:
            raise ParameterError(
                f"action '{name}' has {count} frame{'s' * (count != 1)} to learn from: give at least {LEAST_FRAMES}, "
                "or "
                "leave it out"
            )
    chosen = [rng.permutation(np.flatnonzero(actions == action))[: settings.frames] for action in range(len(names))]
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
            if group == MOTION:
                raise ParameterError(
                    "how the parts move is seen in no frame: no clip shows the whole body in two frames (a clip of one "
                    "frame does not move). Give longer clips, or learn poses alone with --motion 0"
                )
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


def fold_arrays(models: Sequence[Model]) -> dict[str, np.ndarray]:
    """Models of the same actions and groups as flat arrays; `of_fold_arrays` is the inverse. As `arrays`, the
    components of one model after those of the other, in single precision.
    """
    each = [arrays(model) for model in models]
    found = {name: np.stack([one[name] for one in each]) for name in ("alpha", "dimensions")}
    found |= {name: _padded([one[name] for one in each]) for name in ("shift", "matrix")}
    found |= {name: np.concatenate([one[name] for one in each]) for name in PER_COMPONENT}
    found |= {name: _padded([x for one in each for x in one[name]]).astype(np.float32) for name in SHAPES}
    found["component_model"] = np.repeat(np.arange(len(each)), [len(one["dof"]) for one in each])
    return {f"fold_{name}": values for name, values in found.items()}


def of_fold_arrays(arrays: Mapping[str, Any]) -> tuple[Model, ...]:
    """The models that `fold_arrays` wrote into the arrays of a model of all people; none where there are none."""
    shared, found = {name: arrays[name] for name in ("actions", "groups", "features")}, []
    for number in range(len(arrays.get("fold_alpha", ()))):
        rows = arrays["fold_component_model"] == number
        own = {name: arrays[f"fold_{name}"][number] for name in ("alpha", "dimensions", "shift", "matrix")}
        own |= {name: arrays[f"fold_{name}"][rows] for name in PER_COMPONENT}
        own |= {name: arrays[f"fold_{name}"][rows].astype(np.float64) for name in SHAPES}
        found.append(of_arrays(shared | own))
    return tuple(found)


def body_arrays(
    skeleton: Skeleton, groups: Groups, lengths: np.ndarray, names: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """The skeleton, its groups and bone lengths (j,) as flat arrays; `names` are the groups of the model.

    `body_of_arrays` is the inverse.
    """
    member = [(names.index(part), joint) for part, joints in groups.indices(skeleton).items() for joint in joints]
    roles = {name: np.array(getattr(groups, name), np.str_) for name in ("root", "left", "right", "top", "bottom")}
    return roles | {
        "joints": np.array(skeleton.joints, np.str_),
        "parents": np.array(skeleton.parents, np.int64),
        "lengths": lengths,
        "group_members": np.array(member, np.int64).reshape(-1, 2),
        "up": np.array(groups.up, float),
    }


def body_of_arrays(arrays: Mapping[str, Any], source: str) -> Body:
    """The body that `body_arrays` describes; `source` is what messages about its groups name."""
    joints, names = tuple(map(str, arrays["joints"])), tuple(map(str, arrays["groups"]))
    parts = {
        name: tuple(joints[j] for g, j in arrays["group_members"] if g == index)
        for index, name in enumerate(names)
        if name not in (BODY, MOTION)
    }
    left, right, bottom = (tuple(map(str, arrays[role])) for role in ("left", "right", "bottom"))
    x, y, z = map(float, arrays["up"])
    groups = Groups(
        parts,
        root=str(arrays["root"]),
        left=left,
        right=right,
        top=str(arrays["top"]),
        bottom=bottom,
        up=(x, y, z),
        source=source,
    )
    return Body(Skeleton(joints, tuple(map(int, arrays["parents"]))), groups, arrays["lengths"])


def _padded(parts: list[np.ndarray]) -> np.ndarray:
    """Arrays of unequal shape side by side, (n, *largest), 0 beyond each."""
    shape = np.max([part.shape for part in parts], axis=0)
    whole = np.zeros((len(parts), *shape))
    for place, part in zip(whole, parts, strict=True):
        place[tuple(slice(size) for size in part.shape)] = part
    return whole
