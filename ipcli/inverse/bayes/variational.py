"""A Dirichlet process mixture of Gaussians with diagonal covariances, truncated, by variational inference (Blei and
Jordan, Bayesian Analysis 2006), with merge moves.

Sticks v_k ~ Beta(1, alpha); in each dimension a precision ~ Gamma(a0, b0) and a mean ~ N(m0, 1 / (beta0 precision)).
It takes over where collapsed Gibbs sampling does not move: in tens of dimensions a single point never opens a cluster.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ipcli.params import option


@dataclass(frozen=True)
class StickPrior:
    """Prior of the mixture, on data scaled to variance 1 in each dimension."""

    alpha: float = option(1.0, "Concentration of the sticks.", low=1e-6)
    beta: float = option(0.05, "Observations that the mean of a cluster is worth.", low=1e-9)
    shape: float = option(2.0, "Shape a0 of the precisions.", low=1e-6)
    width: float = option(0.2, "Expected variance within a cluster, of that of all.", low=1e-9)


@dataclass(frozen=True, eq=False)
class MixturePosterior:
    """q of K clusters: the sufficient numbers of sticks, means and precisions, and the bound that was reached."""

    counts: np.ndarray  # (k,) expected points of each
    mean: np.ndarray  # (k, d)
    beta: np.ndarray  # (k,)
    shape: np.ndarray  # (k,)
    rate: np.ndarray  # (k, d)
    sticks: np.ndarray  # (k, 2) Beta parameters
    bound: float  # evidence lower bound
    responsibility: np.ndarray = field(repr=False)  # (n, k)

    def log_joint(self, x: np.ndarray) -> np.ndarray:
        """E_q log p(x, cluster) (n, k) of points (n, d): what assignments follow from."""
        from scipy.special import digamma

        log_precision = (digamma(self.shape)[:, None] - np.log(self.rate)).sum(axis=1)
        precision = self.shape[:, None] / self.rate
        far = (x * x) @ precision.T - 2 * x @ (precision * self.mean).T + (precision * self.mean**2).sum(axis=1)
        d = x.shape[1]
        gauss = 0.5 * (log_precision - d * np.log(2 * np.pi) - far - d / self.beta)
        stay, leave = (digamma(self.sticks) - digamma(self.sticks.sum(axis=1, keepdims=True))).T
        return gauss + stay + np.concatenate([[0.0], np.cumsum(leave)[:-1]])

    def assigned(self, x: np.ndarray) -> np.ndarray:
        """Posterior (n, k) over the clusters of points (n, d)."""
        score = self.log_joint(x)
        score = np.exp(score - score.max(axis=1, keepdims=True))
        return score / score.sum(axis=1, keepdims=True)


def fit(
    x: np.ndarray, most: int, prior: StickPrior, rng: np.random.Generator, iterations: int = 100, merges: bool = True
) -> MixturePosterior:
    """q of points (n, d) with at most `most` clusters, from a k-means++ start; clusters are merged while the bound
    rises.
    """
    start = _seeded(x, min(most, len(x)), rng)
    best = _ascended(x, start, prior, iterations)
    merging = merges
    while merging and len(best.counts) > 1:
        merging = False
        for i, j in _close(best):
            joined = np.delete(best.responsibility, j, axis=1)
            joined[:, i - (i > j)] = best.responsibility[:, i] + best.responsibility[:, j]
            tried = _ascended(x, joined, prior, 3)
            if tried.bound > best.bound:
                best, merging = _ascended(x, tried.responsibility, prior, iterations), True
                break
    return best


def updated(x: np.ndarray, responsibility: np.ndarray, prior: StickPrior) -> MixturePosterior:
    """The factors of q that are best given the assignments (n, k), and the bound with them."""
    r, k = responsibility, responsibility.shape[1]
    counts = r.sum(axis=0)
    sums, squares = r.T @ x, r.T @ (x * x)
    beta, shape = prior.beta + counts, prior.shape + counts / 2
    mean = sums / beta[:, None]
    rate = prior.shape * prior.width + 0.5 * (squares - beta[:, None] * mean**2)
    later = counts[::-1].cumsum()[::-1] - counts
    sticks = np.stack([1 + counts, prior.alpha + later], axis=-1)
    made = MixturePosterior(counts, mean, beta, shape, np.maximum(rate, 1e-12), sticks, 0.0, r)
    return _bounded(made, x.shape[1], k, prior)


def _bounded(q: MixturePosterior, d: int, k: int, prior: StickPrior) -> MixturePosterior:
    """With the parameters at their best the bound is the log of the normalisers, and the entropy of the assignments."""
    from scipy.special import betaln, gammaln

    b0 = prior.shape * prior.width
    data = -0.5 * d * q.counts.sum() * np.log(2 * np.pi)
    gauss = (
        0.5 * d * (np.log(prior.beta) - np.log(q.beta)).sum()
        + d * (gammaln(q.shape) - gammaln(prior.shape)).sum()
        + k * d * prior.shape * np.log(b0)
        - (q.shape[:, None] * np.log(q.rate)).sum()
    )
    sticks = (betaln(*q.sticks.T) - betaln(1.0, prior.alpha)).sum()
    r = q.responsibility
    entropy = -(r * np.log(np.maximum(r, 1e-300))).sum()
    bound = float(data + gauss + sticks + entropy)
    return MixturePosterior(q.counts, q.mean, q.beta, q.shape, q.rate, q.sticks, bound, r)


def _ascended(x: np.ndarray, responsibility: np.ndarray, prior: StickPrior, iterations: int) -> MixturePosterior:
    """Coordinate ascent until the bound rises by less than a millionth; clusters in order of their size."""
    q = updated(x, responsibility, prior)
    for _ in range(iterations):
        r = q.assigned(x)
        r = r[:, np.argsort(-r.sum(axis=0), kind="stable")]
        new = updated(x, r, prior)
        done = new.bound - q.bound < 1e-6 * abs(q.bound)
        q = new if new.bound > q.bound else q
        if done:
            break
    kept = q.counts > 0.5
    return q if kept.all() else updated(x, _normalised(q.responsibility[:, kept]), prior)


def _normalised(r: np.ndarray) -> np.ndarray:
    return r / np.maximum(r.sum(axis=1, keepdims=True), 1e-300)


def _seeded(x: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Assignments (n, count) to the nearest of the centres of k-means++."""
    centres = [x[int(rng.integers(len(x)))]]
    away = ((x - centres[0]) ** 2).sum(axis=1)
    while len(centres) < count and away.sum() > 0:
        centres.append(x[int(rng.choice(len(x), p=away / away.sum()))])
        away = np.minimum(away, ((x - centres[-1]) ** 2).sum(axis=1))
    near = np.stack([((x - c) ** 2).sum(axis=1) for c in centres], axis=-1).argmin(axis=1)
    return np.eye(len(centres))[near]


def _close(q: MixturePosterior) -> list[tuple[int, int]]:
    """Pairs of clusters, the closest first in spreads of theirs, at most 20."""
    spread = q.rate / np.maximum(q.shape - 1, 0.5)[:, None]
    i, j = np.triu_indices(len(q.counts), 1)
    far = ((q.mean[i] - q.mean[j]) ** 2 / (spread[i] + spread[j])).mean(axis=1)
    return [(int(i[k]), int(j[k])) for k in np.argsort(far, kind="stable")[:20]]
