"""Hyperparameters of the mixture, their priors, and their conditionals given the clusters (Rasmussen 2000, Gorur and
Rasmussen 2010).

In the coordinates of the chain, where the mean of the data is 0 and their covariance I. The conditionals of xi, rho, W
and beta are given a mean and a precision per cluster, drawn for the purpose and forgotten again; that of alpha is given
their number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ipcli.inverse.bayes import wishart
from ipcli.inverse.bayes.normal_wishart import NormalWishart, SetStatistics
from ipcli.inverse.bayes.parameters import Hyperprior
from ipcli.inverse.bayes.slice import draw as slice_draw


@dataclass(frozen=True, eq=False)
class Hyperparameters:
    """S ~ Wishart(beta, (beta W)^-1), mu | S ~ N(xi, (rho S)^-1), concentration alpha."""

    xi: np.ndarray  # (d,)
    rho: float
    w: np.ndarray  # (d, d), the covariance within a cluster: E S = W^-1
    beta: float  # > d - 1
    alpha: float

    def base(self) -> NormalWishart:
        """The base measure of the Dirichlet process."""
        return NormalWishart.one(self.xi, self.rho, self.beta, self.beta * self.w)

    def flat(self) -> np.ndarray:
        """All of it in one array: rho, beta, alpha, xi, W."""
        return np.concatenate([[self.rho, self.beta, self.alpha], self.xi, self.w.ravel()])

    @classmethod
    def of_flat(cls, values: np.ndarray, d: int) -> Hyperparameters:
        """The inverse of `flat`."""
        rho, beta, alpha = (float(value) for value in values[:3])
        return cls(values[3 : 3 + d].copy(), rho, values[3 + d :].reshape(d, d).copy(), beta, alpha)


@dataclass(frozen=True)
class ClusterDraws:
    """What the conditionals take from one mean mu and one precision S per cluster."""

    count: int
    precision: np.ndarray  # (d, d), sum of S
    weighted: np.ndarray  # (d,), sum of S mu
    root: np.ndarray  # (k, d, d), F with S = F F'
    mean: np.ndarray  # (k, d)
    log_det: float  # sum of log |S|

    @classmethod
    def draw(cls, base: NormalWishart, points: SetStatistics, rng: np.random.Generator) -> ClusterDraws:
        """A mean and a precision from the posterior of each cluster."""
        mean, root = base.posterior(points).sample(rng)
        each = root @ root.swapaxes(1, 2)
        return cls(
            count=len(mean),
            precision=each.sum(axis=0),
            weighted=np.einsum("kij,kj->i", each, mean),
            root=root,
            mean=mean,
            log_det=float(np.linalg.slogdet(each)[1].sum()),
        )

    def spread(self, xi: np.ndarray) -> float:
        """sum of (mu - xi)' S (mu - xi)"""
        return float(np.sum(np.einsum("kji,kj->ki", self.root, self.mean - xi) ** 2))


@dataclass(frozen=True)
class Prior:
    """A `Hyperprior` at dimension d."""

    settings: Hyperprior
    d: int

    @property
    def w_dof(self) -> float:
        """Degrees of freedom of W."""
        return max(self.settings.w_dof or self.d, self.d)

    @property
    def beta_rate(self) -> float:
        """Rate of the Gamma of 1 / (beta - d + 1)."""
        return self.settings.beta_shape / (self.settings.beta_mean or 1 / max(self.d, 1))

    def start(self) -> Hyperparameters:
        """Where a chain begins, and what stays of it if it is not learned."""
        s = self.settings
        return Hyperparameters(np.zeros(self.d), s.rho, s.w_scale * np.eye(self.d), self.d + s.beta_excess, s.alpha)

    def draw(self, rng: np.random.Generator) -> Hyperparameters:
        """A draw from the prior."""
        s, d = self.settings, self.d
        return Hyperparameters(
            xi=math.sqrt(s.xi_spread) * rng.standard_normal(d),
            rho=rng.gamma(s.rho_shape) / s.rho_rate,
            w=wishart.draw(self.w_dof, self.w_dof / s.w_scale * np.eye(d), rng),
            beta=d - 1 + self.beta_rate / rng.gamma(s.beta_shape),
            alpha=s.alpha_rate / rng.gamma(s.alpha_shape),
        )

    def log_density(self, at: Hyperparameters) -> float:
        """log prior density of those that are learned."""
        s, d = self.settings, self.d
        y = at.beta - d + 1
        terms = {
            "xi": -0.5 * float(at.xi @ at.xi) / s.xi_spread - 0.5 * d * math.log(2 * math.pi * s.xi_spread),
            "rho": (s.rho_shape - 1) * math.log(at.rho)
            - s.rho_rate * at.rho
            + _gamma_constant(s.rho_shape, s.rho_rate),
            "w": wishart.log_density(at.w, self.w_dof, self.w_dof / s.w_scale * np.eye(d)),
            "beta": -(s.beta_shape + 1) * math.log(y)
            - self.beta_rate / y
            + _gamma_constant(s.beta_shape, self.beta_rate),
            "alpha": _gamma_constant(s.alpha_shape, s.alpha_rate)
            - (s.alpha_shape + 1) * math.log(at.alpha)
            - s.alpha_rate / at.alpha,
        }
        return sum(terms[name] for name in s.learned)

    def update(self, at: Hyperparameters, points: SetStatistics, rng: np.random.Generator) -> Hyperparameters:
        """One draw of each learned hyperparameter from its conditional, given the points of every cluster."""
        learned = self.settings.learned
        if {"xi", "rho", "w", "beta"} & {*learned}:
            clusters = ClusterDraws.draw(at.base(), points, rng)
            for name in ("xi", "rho", "w", "beta"):
                if name in learned:
                    at = replace(at, **{name: getattr(self, f"_{name}")(at, clusters, rng)})
        if "alpha" in learned:
            at = replace(at, alpha=self._alpha(at.alpha, len(points.count), int(points.count.sum()), rng))
        return at

    def _xi(self, at: Hyperparameters, clusters: ClusterDraws, rng: np.random.Generator) -> np.ndarray:
        precision = np.eye(self.d) / self.settings.xi_spread + at.rho * clusters.precision
        chol = np.linalg.cholesky(precision)
        centre = np.linalg.solve(precision, at.rho * clusters.weighted)
        return centre + np.linalg.solve(chol.T, rng.standard_normal(self.d))

    def _rho(self, at: Hyperparameters, clusters: ClusterDraws, rng: np.random.Generator) -> float:
        shape = self.settings.rho_shape + 0.5 * clusters.count * self.d
        return rng.gamma(shape) / (self.settings.rho_rate + 0.5 * clusters.spread(at.xi))

    def _w(self, at: Hyperparameters, clusters: ClusterDraws, rng: np.random.Generator) -> np.ndarray:
        inverse_scale = self.w_dof / self.settings.w_scale * np.eye(self.d) + at.beta * clusters.precision
        return wishart.draw(self.w_dof + clusters.count * at.beta, inverse_scale, rng)

    def _beta(self, at: Hyperparameters, clusters: ClusterDraws, rng: np.random.Generator) -> float:
        d, k, shape, rate = self.d, clusters.count, self.settings.beta_shape, self.beta_rate
        fit = k * float(np.linalg.slogdet(at.w)[1]) + clusters.log_det - float(np.sum(at.w * clusters.precision))

        def log_density(t: float) -> float:
            y = math.exp(t)
            half = 0.5 * (y + d - 1)
            return (
                k * (half * d * math.log(half) - float(wishart.log_gamma(half, d))) + half * fit - shape * t - rate / y
            )

        return d - 1 + math.exp(slice_draw(log_density, math.log(at.beta - d + 1), rng))

    def _alpha(self, alpha: float, k: int, n: int, rng: np.random.Generator) -> float:
        shape, rate = self.settings.alpha_shape, self.settings.alpha_rate

        def log_density(t: float) -> float:
            return (k - shape) * t - rate * math.exp(-t) + math.lgamma(math.exp(t)) - math.lgamma(n + math.exp(t))

        return math.exp(slice_draw(log_density, math.log(alpha), rng))


def _gamma_constant(shape: float, rate: float) -> float:
    return shape * math.log(rate) - math.lgamma(shape)
