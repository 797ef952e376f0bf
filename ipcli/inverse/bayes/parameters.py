"""Parameters of the Dirichlet process mixture, declared once for flags, configuration files and provenance."""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.params import option

LEARNED = ("xi", "rho", "w", "beta", "alpha")


@dataclass(frozen=True)
class Hyperprior:
    """Priors of the hyperparameters (Rasmussen 2000; Gorur and Rasmussen 2010); the defaults are theirs.

    With m and C the mean and covariance that the data are measured by, and d their dimension: xi ~ N(m, xi_spread C); W
    ~ Wishart(w_dof, w_scale C / w_dof), so E W = w_scale C; rho ~ Gamma(rho_shape, rate rho_rate); 1 / (beta - d + 1) ~
    Gamma(beta_shape, mean beta_mean); 1 / alpha ~ Gamma(alpha_shape, rate alpha_rate). Shapes and rates are those of
    the density x^(shape - 1) exp(-rate x); Rasmussen's G(a, b) has shape a / 2 and mean b.
    """

    xi_spread: float = option(1.0, "covariance of the clusters' mean, over that of the data", low=1e-9)
    w_dof: float = option(0.0, "degrees of freedom of W, at least the dimension; 0: the dimension", low=0.0)
    w_scale: float = option(1.0, "mean of W, the covariance within a cluster, over that of the data", low=1e-9)
    rho_shape: float = option(0.5, "shape of rho, the precision of the cluster means", low=1e-9)
    rho_rate: float = option(0.5, "rate of rho", low=1e-9)
    beta_shape: float = option(0.5, "shape of 1 / (beta - d + 1), beta the degrees of freedom of a precision", low=1e-9)
    beta_mean: float = option(0.0, "mean of 1 / (beta - d + 1); 0: 1 / d", low=0.0)
    alpha_shape: float = option(0.5, "shape of 1 / alpha, alpha the concentration", low=1e-9)
    alpha_rate: float = option(0.5, "rate of 1 / alpha", low=1e-9)
    learned: tuple[str, ...] = option(LEARNED, "hyperparameters that are sampled; the others stay", choices=LEARNED)
    rho: float = option(0.1, "rho at the start", low=1e-9)
    beta_excess: float = option(1.0, "beta - d at the start", low=-0.999)
    alpha: float = option(1.0, "alpha at the start", low=1e-9)


@dataclass(frozen=True)
class Mixture:
    """How a Dirichlet process mixture is sampled and what of it is kept."""

    sweeps: int = option(100, "sweeps of Gibbs sampling in each chain", low=1)
    burn_in: int = option(50, "sweeps before the first that is kept", low=0)
    thin: int = option(5, "sweeps from one that is kept to the next", low=1)
    chains: int = option(1, "chains, each from a start of its own", low=1)
    start: int = option(0, "clusters at the start; 0: a tenth of the points, from 1 to 50", low=0)
    moves: int = option(5, "split-merge moves after each sweep", low=0)
    scans: int = option(3, "restricted scans before a split or merge is proposed", low=0)
    resolution: float = option(
        1e-3, "noise added to the data, over their standard deviation, so that repeated points have a density", low=0.0
    )
    prior: Hyperprior = field(default_factory=Hyperprior)
