"""One Markov chain over the partitions and the hyperparameters of a Dirichlet process mixture of Gaussians."""

from __future__ import annotations

import math

import numpy as np

from ipcli.inverse.bayes import generator
from ipcli.inverse.bayes.hyperparameters import Hyperparameters, Prior
from ipcli.inverse.bayes.normal_wishart import SetStatistics
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.kernels import dirichlet

TRACE = ("clusters", "log_joint", "alpha", "rho", "beta", "splits", "merges")
MOST_AT_START = 50  # clusters


class Chain:
    """Collapsed Gibbs sweeps (Neal 2000, Algorithm 3), split-merge moves and updates of the hyperparameters.

    `x` (n, d) float64 is in coordinates where the prior's mean is 0 and its covariance I. The chain is a function of x,
    settings and the generator alone; `state` and `restore` carry it over an interruption to the same end.
    """

    def __init__(self, x: np.ndarray, settings: Mixture, rng: np.random.Generator):
        self.x, self.settings, self.rng = np.ascontiguousarray(x, np.float64), settings, rng
        self.prior = Prior(settings.prior, self.x.shape[1])
        self.hyper = self.prior.start()
        self.labels = seeded(self.x, settings.start or min(max(len(x) // 10, 1), MOST_AT_START), rng)
        self.trace: list[tuple[float, ...]] = []  # a row of TRACE a sweep
        self.kept_labels: list[np.ndarray] = []
        self.kept_hyper: list[np.ndarray] = []

    @property
    def clusters(self) -> int:
        """Their number."""
        return int(self.labels.max()) + 1

    @property
    def is_done(self) -> bool:
        """Whether all sweeps are done."""
        return len(self.trace) >= self.settings.sweeps

    def advance(self, sweeps: int) -> None:
        """So many sweeps, or as many as are left."""
        for _ in range(min(sweeps, self.settings.sweeps - len(self.trace))):
            splits, merges = self.move()
            points = self.learn()
            h = self.hyper
            self.trace.append((self.clusters, self.log_joint(points), h.alpha, h.rho, h.beta, splits, merges))
            after = len(self.trace) - 1 - self.settings.burn_in
            if after >= 0 and after % self.settings.thin == 0:
                self.kept_labels.append(self.labels.copy())
                self.kept_hyper.append(h.flat())

    def move(self) -> tuple[int, int]:
        """Move the labels at fixed hyperparameters: a Gibbs sweep, then split-merge moves; (splits, merges)
        accepted.
        """
        base = self.base()
        k, _ = dirichlet.sweep(self.x, self.labels, self.clusters, *base, self.rng)
        _, splits, merges = dirichlet.split_merge(
            self.x, self.labels, k, *base, self.settings.moves, self.settings.scans, self.rng
        )
        return splits, merges

    def learn(self) -> SetStatistics:
        """Move the hyperparameters at fixed labels; the statistics of the clusters."""
        points = SetStatistics.of(self.x, self.labels, self.clusters)
        self.hyper = self.prior.update(self.hyper, points, self.rng)
        return points

    def base(self) -> tuple[np.ndarray, float, float, np.ndarray, float]:
        """The base measure and the concentration as the kernels take them: xi, rho, beta, Cholesky factor of beta W,
        alpha.
        """
        h = self.hyper
        return h.xi, h.rho, h.beta, np.linalg.cholesky(h.beta * h.w), h.alpha

    def log_joint(self, points: SetStatistics) -> float:
        """log p(x, labels, learned hyperparameters)."""
        return (
            float(self.hyper.base().log_marginal(points).sum())
            + log_partition(points.count, self.hyper.alpha)
            + self.prior.log_density(self.hyper)
        )

    def state(self) -> dict[str, np.ndarray]:
        """All that the chain needs to go on, as numeric arrays."""
        n, width = len(self.x), len(self.hyper.flat())
        return {
            "labels": self.labels.copy(),
            "hyper": self.hyper.flat(),
            "trace": np.array(self.trace, float).reshape(-1, len(TRACE)),
            "kept_labels": np.array(self.kept_labels, np.int32).reshape(-1, n),
            "kept_hyper": np.array(self.kept_hyper, float).reshape(-1, width),
            "generator": generator.state(self.rng),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go back to where `state` was taken, with the same x and settings."""
        self.labels = np.array(state["labels"], np.int32)
        self.hyper = Hyperparameters.of_flat(np.asarray(state["hyper"], float), self.x.shape[1])
        self.trace = [tuple(row) for row in np.asarray(state["trace"]).tolist()]
        self.kept_labels = list(np.asarray(state["kept_labels"], np.int32))
        self.kept_hyper = list(np.asarray(state["kept_hyper"], float))
        generator.restore(self.rng, state["generator"])


def log_partition(count: np.ndarray, alpha: float) -> float:
    """log probability of a partition into sets of these sizes under the Chinese restaurant process."""
    from scipy.special import gammaln

    n = count.sum()
    return float(len(count) * math.log(alpha) + gammaln(count).sum() + math.lgamma(alpha) - math.lgamma(alpha + n))


def seeded(x: np.ndarray, k: int, rng: np.random.Generator) -> np.ndarray:
    """Labels (n,) int32 of the nearest of up to k points, drawn far from each other as k-means++ does."""
    nearest = np.full(len(x), np.inf)
    labels = np.zeros(len(x), np.int32)
    seed = int(rng.integers(len(x)))
    for j in range(min(k, len(x))):
        distance = np.sum((x - x[seed]) ** 2, axis=1)
        closer = distance < nearest
        labels[closer], nearest[closer] = j, distance[closer]
        if not nearest.sum() > 0:
            break
        seed = int(rng.choice(len(x), p=nearest / nearest.sum()))
    return np.unique(labels, return_inverse=True)[1].astype(np.int32)
