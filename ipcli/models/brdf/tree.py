"""What a patch says of the surface under it: a tree of Dirichlet process mixtures (thesis 7.4.2).

Each level clusters one group of features within each cluster of the level before: heights, then normals, then the look.
That is a nested Chinese restaurant's prior on paths with an emission a level, neither Rodriguez' nested process nor the
plain one; given the parents every node is an ordinary mixture, so it is learnt from the top down. Learnt for one
reflectance map, it gives the posterior of the normal at a patch of which only the look is seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.inverse.bayes.variational import MixturePosterior, StickPrior, fit

SMALLEST = 50  # points below which a node is not divided


@dataclass(frozen=True, eq=False)
class PathEnd:
    """The end of a path."""

    log_share: float  # log prior of the path
    look: MixturePosterior  # mixture of the appearance under this path
    normals: np.ndarray  # (k, 3) sum of responsibility times normal, over all points, of each of its clusters
    counts: np.ndarray  # (k,)


@dataclass(frozen=True, eq=False)
class Tree:
    """A learnt tree: the scale of the look, and the leaves."""

    mean: np.ndarray  # (f,)
    spread: np.ndarray  # (f,)
    leaves: tuple[PathEnd, ...]


@dataclass(frozen=True, eq=False)
class PatchPosterior:
    """What each patch says of its normal."""

    normals: np.ndarray  # (m, 3) direction of the mean
    concentration: np.ndarray  # (m,) length of the mean: 1 certain, 0 nothing known
    evidence: np.ndarray  # (m,) log density of the look under the map the tree was learnt for


def learn(
    groups: Sequence[np.ndarray],
    look: np.ndarray,
    normals: np.ndarray,
    rng: np.random.Generator,
    most: Sequence[int] = (6, 8, 8),
    prior: StickPrior | None = None,
) -> Tree:
    """A tree of points whose hidden `groups` (n, .) are clustered level by level, and then their `look` (n, f); unit
    normals (n, 3) are what is wanted. `most` bounds the children of a node at each level.
    """
    hidden = [_scaled(group) for group in groups]
    mean, spread = look.mean(axis=0), np.maximum(look.std(axis=0), 1e-9)
    seen = (look - mean) / spread
    leaves: list[PathEnd] = []
    prior = prior or StickPrior()
    for points in _paths(np.arange(len(look)), hidden, rng, most, prior):
        count = most[len(groups)] if len(points) >= SMALLEST else 1
        q = fit(seen[points], count, prior, rng)
        share = float(np.log(len(points) / len(look)))
        leaves.append(PathEnd(share, q, q.responsibility.T @ normals[points], q.counts))
    return Tree(mean, spread, tuple(leaves))


def _scaled(group: np.ndarray) -> np.ndarray:
    return (group - group.mean(axis=0)) / np.maximum(group.std(axis=0), 1e-9)


def _paths(
    points: np.ndarray, hidden: Sequence[np.ndarray], rng: np.random.Generator, most: Sequence[int], prior: StickPrior
) -> list[np.ndarray]:
    """The points of each path below a node that holds `points`."""
    if not hidden:
        return [points]
    if len(points) < SMALLEST:
        return _paths(points, hidden[1:], rng, most[1:], prior)
    labels = fit(hidden[0][points], most[0], prior, rng).responsibility.argmax(axis=1)
    below = [_paths(points[labels == k], hidden[1:], rng, most[1:], prior) for k in np.unique(labels)]
    return [path for paths in below for path in paths]


def posterior(tree: Tree, look: np.ndarray) -> PatchPosterior:
    """The posterior of the normals at patches of which only the look (m, f) is seen: all leaves, weighed."""
    seen = (look - tree.mean) / tree.spread
    scores = np.concatenate([leaf.log_share + leaf.look.log_joint(seen) for leaf in tree.leaves], axis=1)
    normals = np.concatenate([leaf.normals / np.maximum(leaf.counts, 1e-9)[:, None] for leaf in tree.leaves])
    top = scores.max(axis=1, keepdims=True)
    weight = np.exp(scores - top)
    total = weight.sum(axis=1, keepdims=True)
    mean = weight @ normals / total
    length = np.linalg.norm(mean, axis=1)
    return PatchPosterior(mean / np.maximum(length, 1e-12)[:, None], length, (top + np.log(total))[:, 0])
