"""Wishart distribution of precision matrices: draws by Bartlett's decomposition, density, multivariate gamma function.

S ~ Wishart(b, V): E S = b V, p(S) ~ |S|^((b - d - 1) / 2) exp(-tr(V^-1 S) / 2), b > d - 1.
"""

from __future__ import annotations

import math

import numpy as np


def bartlett(dof: np.ndarray, d: int, rng: np.random.Generator) -> np.ndarray:
    """Lower factors A (k, d, d) with A A' ~ Wishart(dof, I), for the degrees of freedom (k,), each above d - 1."""
    dof = np.asarray(dof, float)
    factor = np.zeros((len(dof), d, d))
    rows, columns = np.tril_indices(d, -1)
    factor[:, rows, columns] = rng.standard_normal((len(dof), len(rows)))
    at = np.arange(d)
    factor[:, at, at] = np.sqrt(rng.chisquare(dof[:, None] - at))
    return factor


def draw(dof: float, inverse_scale: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A precision S (d, d) ~ Wishart(dof, inverse_scale^-1)."""
    root = root_from(dof=np.array([dof]), chol=np.linalg.cholesky(inverse_scale)[None], rng=rng)[0]
    return root @ root.T


def root_from(dof: np.ndarray, chol: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Roots F (k, d, d) of precisions S = F F' ~ Wishart(dof, (chol chol')^-1), for lower `chol` (k, d, d)."""
    factor = bartlett(dof, chol.shape[-1], rng)
    return np.linalg.solve(chol.swapaxes(-1, -2), factor) if chol.shape[-1] else factor


def log_density(s: np.ndarray, dof: float, inverse_scale: np.ndarray) -> float:
    """log p(S) of Wishart(dof, inverse_scale^-1)."""
    d = len(s)
    log_s, log_v = np.linalg.slogdet(s)[1], np.linalg.slogdet(inverse_scale)[1]
    normaliser = 0.5 * dof * (d * math.log(2) - log_v) + log_gamma(0.5 * dof, d)
    return float(0.5 * (dof - d - 1) * log_s - 0.5 * np.sum(inverse_scale * s) - normaliser)


def log_gamma(a: np.ndarray | float, d: int) -> np.ndarray | float:
    """log of the multivariate gamma function Gamma_d(a), at one number or at many."""
    constant = 0.25 * d * (d - 1) * math.log(math.pi)
    if isinstance(a, float):  # a slice sampler asks for one after the other
        return constant + sum(math.lgamma(a - 0.5 * i) for i in range(d))
    from scipy.special import gammaln

    return constant + gammaln(np.subtract.outer(a, 0.5 * np.arange(d))).sum(axis=-1)
