"""Which action a frame, a clip, some of its frames in no order or a window of a take shows, or none (5.10, 5.11)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipcli.errors import ParameterError
from ipcli.models.mocap import preferences
from ipcli.models.mocap.behaviours import Model, with_body
from ipcli.models.mocap.parameters import BODY, MOTION, Decision

NONE = -1  # the answer "none of these"
CHUNK = 65536  # frames at a time, whose coordinates are in memory


@dataclass(frozen=True, eq=False)
class Answer:
    """What was recognised in q queries."""

    action: np.ndarray  # (q,) int, index of the action; NONE
    posterior: np.ndarray  # (q, a), adds to 1, as if one of them it must be
    novelty: np.ndarray  # (q,), how unlike all that was learnt of the best action; NaN if no frame could be used
    frames: np.ndarray  # (q,) int, frames that could be used


def log_densities(model: Model, features: Mapping[str, np.ndarray]) -> np.ndarray:
    """log p(features of group | action) (f, a, g) in each frame (5.10); NaN where a group was not seen.

    `features` (f, D) by name of group, as `features.of_motion` gives them. Raises ParameterError for a group that is
    not there.
    """
    whole = with_body(features, BODY in model.groups)
    if missing := [group for group in model.groups if group not in whole]:
        raise ParameterError(
            f"the model asks for group '{missing[0]}', the features have {', '.join(features)}. Give the groups file "
            "it was made with"
        )
    found = np.full((len(next(iter(whole.values()))), len(model.actions), len(model.groups)), np.nan)
    for g, (group, project) in enumerate(zip(model.groups, model.projections, strict=True)):
        seen = np.flatnonzero(np.isfinite(whole[group]).all(axis=1))
        for rows in np.array_split(seen, max(-(-len(seen) // CHUNK), 1)):
            points = project(whole[group][rows])
            for a in range(len(model.actions)):
                found[rows, a, g] = model.predictives[a][g].log_density(points)
    return found


def poses_alone(model: Model, log_density: np.ndarray) -> np.ndarray:
    """The densities (f, a, g) as if no frame told what comes before it or after: those of MOTION not known."""
    return np.where(np.array(model.groups) == MOTION, np.nan, log_density)


def group_posteriors(log_density: np.ndarray) -> np.ndarray:
    """log posterior (f, a, g) of the actions by each group alone, all actions equally likely before; NaN where not
    seen.
    """
    from scipy.special import logsumexp

    return log_density - logsumexp(log_density, axis=1, keepdims=True)


def frame_posteriors(model: Model, log_density: np.ndarray, decision: Decision) -> np.ndarray:
    """log posterior (f, a) of the actions in each frame, from log densities (f, a, g); NaN where no group was seen.

    Groups that were not seen are left out. `preferences` mixes the groups' normalised posteriors by W of (5.12): of
    bare densities, as the thesis writes W'F, the group with the sharpest would decide alone.
    """
    from scipy.special import logsumexp

    seen = np.isfinite(log_density).all(axis=1)
    posterior = group_posteriors(log_density)
    if decision.rule == "product":
        score = np.where(seen[:, None], posterior, 0.0) @ _powers(model.groups, decision)
    else:
        weight = np.ones(model.alpha.shape) if decision.rule == "mean" else preference(model, decision)
        mixed = np.einsum("fag,ag->fa", np.where(seen[:, None], np.exp(posterior), 0.0), weight)
        with np.errstate(divide="ignore"):
            score = np.log(mixed)
    score = score - logsumexp(score, axis=1, keepdims=True)
    return np.where(seen.any(axis=1)[:, None], score, np.nan)


def preference(model: Model, decision: Decision) -> np.ndarray:
    """The preference matrix W (a, g) of (5.12). Raises ParameterError where the printed form does not give weights."""
    rule = preferences.corrected if decision.preference == "corrected" else preferences.printed
    weights = rule(model.alpha, decision.prior_successes)
    bad = ~(np.isfinite(weights) & (weights >= 0)).all(axis=1)
    if bad.any():
        name = model.actions[int(bad.argmax())]
        raise ParameterError(
            f"(5.12) as printed gives no weights for '{name}': its denominator or a success is not positive. Take the "
            "corrected form"
        )
    return weights


def _powers(groups: tuple[str, ...], decision: Decision) -> np.ndarray:
    own = {BODY: decision.body_power, MOTION: decision.motion_power}
    return np.array([own.get(group, decision.power) for group in groups])


def novelty_scores(model: Model, log_density: np.ndarray) -> np.ndarray:
    """Score how unlike each action each pose is, (f, a): minus the log density of a dimension, the mean over the groups
    seen but MOTION.
    """
    seen = np.isfinite(poses_alone(model, log_density)).all(axis=1)
    size = np.array([project.matrix.shape[1] for project in model.projections])
    total = -np.where(seen[:, None], log_density, 0.0).sum(axis=2)
    known = seen @ size
    return np.divide(total, known[:, None], out=np.full(total.shape, np.nan), where=known[:, None] > 0)


def answer(
    posterior: np.ndarray,
    novelty: np.ndarray,
    query: np.ndarray,
    queries: int,
    decision: Decision,
    threshold: float = np.inf,
) -> Answer:
    """What each query shows, from the frames' log posteriors (f, a) and novelty scores (f, a); query (f,) int, the
    query of each frame.

    The mean log posterior of the frames that could be used counts as much as `decision.evidence` independent frames, or
    as their number if that is less. In which order they come makes no difference. A query is NONE if its novelty
    score is above `threshold`, or nothing of it could be used.
    """
    from scipy.special import softmax

    known = np.isfinite(posterior).any(axis=1)
    frames = np.bincount(query[known], minlength=queries)
    floor = np.maximum(posterior[known], np.log(np.finfo(float).tiny))
    mean, strange = (_means(values, query[known], queries, frames) for values in (floor, novelty[known]))
    share = softmax(mean * np.minimum(frames, decision.evidence)[:, None], axis=1)
    best = share.argmax(axis=1)
    unlike = np.where(frames > 0, strange[np.arange(queries), best], np.nan)
    return Answer(np.where(unlike <= threshold, best, NONE), share, unlike, frames)


def _means(values: np.ndarray, query: np.ndarray, queries: int, frames: np.ndarray) -> np.ndarray:
    columns = [np.bincount(query, weights=column, minlength=queries) for column in values.T]
    return np.stack(columns, axis=1) / np.maximum(frames, 1)[:, None]


def threshold(novelty: np.ndarray, decision: Decision) -> float:
    """The novelty score above which a query is none of the actions: the quantile `decision.reject` of those of clips
    that were actions.
    """
    known = novelty[np.isfinite(novelty)]
    return float(np.quantile(known, decision.reject)) if len(known) and decision.reject < 1 else np.inf


def draw_unordered(query: np.ndarray, frames: int, rng: np.random.Generator) -> np.ndarray:
    """Draw `frames` of the frames of each query, or all if it has fewer: indices in random order; query (f,) int."""
    order = rng.permutation(len(query))
    by_query = order[np.argsort(query[order], kind="stable")]
    rank = np.arange(len(query)) - np.searchsorted(query[by_query], query[by_query])
    return rng.permutation(by_query[rank < frames])


def windows(frames: int, width: int, step: int) -> np.ndarray:
    """First frame and frame after the last (w, 2) of windows along a take; the last one ends where the take ends."""
    first = np.arange(0, max(frames - width, 0) + step, step)
    return np.stack([np.minimum(first, max(frames - width, 0)), np.minimum(first + width, frames)], axis=1)
