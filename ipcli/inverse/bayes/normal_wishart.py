"""The Normal-Wishart distribution, conjugate to a Gaussian of unknown mean and precision (thesis 5.9, with the scale
corrected).

S ~ Wishart(beta, psi^-1), mu | S ~ N(mean, (rho S)^-1). The thesis prints the Wishart's scale as (beta W^-1); Rasmussen
(2000) has (beta W)^-1, that is psi = beta W and E S = W^-1. A `NormalWishart` holds k of them, side by side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ipcli.inverse.bayes import wishart
from ipcli.inverse.bayes.student import Students
from ipcli.kernels import points


@dataclass(frozen=True, eq=False)
class SetStatistics:
    """Sufficient statistics of k sets of points."""

    count: np.ndarray  # (k,)
    mean: np.ndarray  # (k, d)
    scatter: np.ndarray  # (k, d, d), sum of (x - mean) (x - mean)'

    @classmethod
    def of(cls, x: np.ndarray, labels: np.ndarray, k: int) -> SetStatistics:
        """Sum up the points x (n, d) with each of the labels 0 ... k - 1; an empty set has mean 0."""
        return cls(*points.statistics(np.ascontiguousarray(x, np.float64), np.asarray(labels, np.int32), k))


@dataclass(frozen=True, eq=False)
class NormalWishart:
    """k Normal-Wishart distributions."""

    mean: np.ndarray  # (k, d)
    rho: np.ndarray  # (k,)
    beta: np.ndarray  # (k,), > d - 1
    psi: np.ndarray  # (k, d, d), inverse scale

    @classmethod
    def one(cls, mean: np.ndarray, rho: float, beta: float, psi: np.ndarray) -> NormalWishart:
        """A single one (k = 1)."""
        return cls(
            np.asarray(mean, float)[None], np.array([rho], float), np.array([beta], float), np.asarray(psi, float)[None]
        )

    @property
    def dimension(self) -> int:
        """d"""
        return self.mean.shape[1]

    def posterior(self, sets: SetStatistics) -> NormalWishart:
        """Given k sets of points; a single prior serves all of them."""
        n, off = sets.count, sets.mean - self.mean
        shrunk = (self.rho * n / (self.rho + n))[:, None, None]
        psi = self.psi + sets.scatter + shrunk * off[:, :, None] * off[:, None, :]
        mean = self.mean + (n / (self.rho + n))[:, None] * off
        return NormalWishart(mean, self.rho + n, self.beta + n, psi)

    def log_marginal(self, sets: SetStatistics) -> np.ndarray:
        """log density (k,) of each set of points, means and precisions integrated out."""
        post = self.posterior(sets)
        return post._log_normaliser() - self._log_normaliser() - 0.5 * self.dimension * sets.count * math.log(math.pi)

    def _log_normaliser(self) -> np.ndarray:
        """log of what a density x^... must be divided by, up to powers of pi and 2 that cancel between prior and
        posterior.
        """
        d = self.dimension
        return (
            wishart.log_gamma(0.5 * self.beta, d)
            - 0.5 * self.beta * np.linalg.slogdet(self.psi)[1]
            - 0.5 * d * np.log(self.rho)
        )

    def predictive(self) -> Students:
        """The t density of the next point of each."""
        dof = self.beta - self.dimension + 1
        scale = self.psi * ((self.rho + 1) / (self.rho * dof))[:, None, None]
        return Students(dof, self.mean, np.linalg.cholesky(scale))

    def sample(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Means (k, d) and roots F (k, d, d) of precisions S = F F', one draw of each."""
        root = wishart.root_from(self.beta, np.linalg.cholesky(self.psi), rng)
        noise = np.linalg.solve(root.swapaxes(1, 2), rng.standard_normal(self.mean.shape)[:, :, None])[:, :, 0]
        return self.mean + noise / np.sqrt(self.rho)[:, None], root
