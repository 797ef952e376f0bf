"""Multivariate Student t densities, side by side and mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Students:
    """m multivariate t densities of d dimensions."""

    dof: np.ndarray  # (m,)
    location: np.ndarray  # (m, d)
    chol: np.ndarray  # (m, d, d), lower Cholesky factor of the scale matrix

    def log_normaliser(self) -> np.ndarray:
        """log density (m,) of each at its location."""
        from scipy.special import gammaln

        d, diagonal = self.location.shape[1], np.diagonal(self.chol, axis1=1, axis2=2)
        gammas = gammaln(0.5 * (self.dof + d)) - gammaln(0.5 * self.dof)
        return gammas - 0.5 * d * np.log(np.pi * self.dof) - np.log(diagonal).sum(axis=1)

    def log_density(self, x: np.ndarray) -> np.ndarray:
        """(n, m) at the points x (n, d)."""
        from scipy.linalg import solve_triangular

        d, squared = self.location.shape[1], np.empty((len(x), len(self.dof)))
        for j, (location, chol) in enumerate(zip(self.location, self.chol, strict=True)):
            squared[:, j] = np.sum(solve_triangular(chol, (x - location).T, lower=True) ** 2, axis=0) if d else 0.0
        return self.log_normaliser() - 0.5 * (self.dof + d) * np.log1p(squared / self.dof)
