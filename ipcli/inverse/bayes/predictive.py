"""The density of a new point: a flat mixture of t densities, one for each cluster of each kept sweep and one for a new
cluster.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.inverse.bayes.hyperparameters import Hyperparameters
from ipcli.inverse.bayes.normal_wishart import SetStatistics
from ipcli.inverse.bayes.student import Students
from ipcli.kernels import student


@dataclass(frozen=True, eq=False)
class Predictive:
    """sum over m of exp(log_weight) t(x | dof, location, chol chol'): the mean over the draws of

        sum_k n_k / (n + alpha) t_k(x) + alpha / (n + alpha) t_0(x),

    Neal's predictive (thesis 5.10). The rows of a draw are its clusters in the order of their labels, then t_0. Arrays
    alone: it can be stored as it is and made again by `Predictive(**arrays)`.
    """

    log_weight: np.ndarray  # (m,), log of weights that add to 1
    dof: np.ndarray  # (m,)
    location: np.ndarray  # (m, d), in the units of the data
    chol: np.ndarray  # (m, d, d), lower Cholesky factors of the scale matrices
    draw: np.ndarray  # (m,) int32, the kept sweep that a component is of: 0, 1, ...

    @classmethod
    def of_draw(cls, x: np.ndarray, labels: np.ndarray, hyper: Hyperparameters) -> Predictive:
        """That of one partition of the points x (n, d) at given hyperparameters."""
        k, n = int(labels.max()) + 1, len(x)
        base, points = hyper.base(), SetStatistics.of(x, labels, k)
        known, new = base.posterior(points).predictive(), base.predictive()
        weight = np.log(np.append(points.count, hyper.alpha) / (n + hyper.alpha))
        dof, location, chol = (
            np.concatenate([getattr(known, name), getattr(new, name)]) for name in ("dof", "location", "chol")
        )
        return cls(weight, dof, location, chol, np.zeros(k + 1, np.int32))

    @classmethod
    def mean(cls, draws: list[Predictive]) -> Predictive:
        """The average of several, each with the same weight, their draws numbered on."""
        firsts = np.cumsum([0, *(part.draws for part in draws)])
        share = np.log(len(draws))
        return cls(
            np.concatenate([part.log_weight - share for part in draws]),
            np.concatenate([part.dof for part in draws]),
            np.concatenate([part.location for part in draws]),
            np.concatenate([part.chol for part in draws]),
            np.concatenate([part.draw + first for part, first in zip(draws, firsts[:-1], strict=True)]).astype(
                np.int32
            ),
        )

    @property
    def draws(self) -> int:
        """How many kept sweeps it averages."""
        return int(self.draw.max()) + 1

    @property
    def students(self) -> Students:
        """Its components without their weights."""
        return Students(self.dof, self.location, self.chol)

    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays it is made of, by name."""
        return {name: getattr(self, name) for name in ("log_weight", "dof", "location", "chol", "draw")}

    def of(self, draws: np.ndarray | int) -> Predictive:
        """The average of some of the draws alone, in their order."""
        parts = [self._one(int(draw)) for draw in np.atleast_1d(draws)]
        return Predictive.mean(parts)

    def _one(self, draw: int) -> Predictive:
        rows = np.flatnonzero(self.draw == draw)
        weight = self.log_weight[rows] + np.log(self.draws)
        return Predictive(weight, self.dof[rows], self.location[rows], self.chol[rows], np.zeros(len(rows), np.int32))

    def thinned(self, draws: int) -> Predictive:
        """At most so many of the draws, evenly spread: less to compute for a density that is averaged less."""
        return self if draws >= self.draws else self.of(np.linspace(0, self.draws - 1, draws).round().astype(int))

    def affine(self, shift: np.ndarray, chol: np.ndarray) -> Predictive:
        """The density of shift + chol y, where y has this one; chol (d, d) lower."""
        return Predictive(self.log_weight, self.dof, shift + self.location @ chol.T, chol @ self.chol, self.draw)

    def log_density(self, x: np.ndarray) -> np.ndarray:
        """log predictive density (n,) at the points x (n, d); NaN where x is not finite."""
        half_dof = 0.5 * (self.dof + self.location.shape[1])
        constant = self.log_weight + self.students.log_normaliser()
        # Inverse factors over sqrt(dof): products in place of solutions, and log(1 + |.|^2) at once.
        inverse = np.linalg.inv(self.chol) / np.sqrt(self.dof)[:, None, None]
        shift = np.einsum("mij,mj->mi", inverse, self.location)
        return student.log_mixture(
            np.ascontiguousarray(x, np.float64), constant, half_dof, shift, np.ascontiguousarray(inverse)
        )

    def responsibilities(self, x: np.ndarray) -> np.ndarray:
        """Posterior probability (n, m) of the components at the points x (n, d)."""
        from scipy.special import softmax

        return softmax(self.log_weight + self.students.log_density(np.asarray(x, float)), axis=1)
