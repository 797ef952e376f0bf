"""Fitting a Dirichlet process mixture of Gaussians: x | mu, S ~ N(mu, S^-1), (mu, S) ~ G, G ~ DP(alpha, Normal-Wishart)
(thesis 5.8, 5.9).

The model with its hyperpriors is affine equivariant, so it is sampled in coordinates where the data have mean 0 and
covariance I.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipcli import threads
from ipcli.errors import ParameterError
from ipcli.inverse.bayes.chain import TRACE, Chain
from ipcli.inverse.bayes.hyperparameters import Hyperparameters
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.inverse.bayes.partitions import nearest
from ipcli.inverse.bayes.predictive import Predictive

State = dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Fitted:
    """What the chains have found. The draws are the kept sweeps, of the first chain, then of the second, ..."""

    predictive: Predictive  # averaged over all draws
    partitions: np.ndarray  # (draws, n) int32, the label of each point in each draw
    log_joint: np.ndarray  # (draws,)
    trace: np.ndarray  # (chains, sweeps, len(TRACE))

    @cached_property
    def typical(self) -> int:
        """The draw nearest to all of them: its labels are the point partition."""
        return nearest(self.partitions)

    @property
    def best(self) -> int:
        """The draw with the highest joint density, which may be an untypical one: hyperparameters weigh in it too."""
        return int(self.log_joint.argmax())

    def labels(self) -> np.ndarray:
        """Labels (n,) of the point partition."""
        return self.partitions[self.typical]

    def behaviours(self) -> Predictive:
        """The mixture of the point partition: row k is the component of label k, the last row that of a new cluster."""
        return self.predictive.of(self.typical)

    def arrays(self) -> dict[str, np.ndarray]:
        """All of it as flat arrays by name; `of_arrays` is the inverse."""
        return self.predictive.arrays() | {name: getattr(self, name) for name in ("partitions", "log_joint", "trace")}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Fitted:
        """What `arrays` describes."""
        own = {name: arrays[name] for name in ("partitions", "log_joint", "trace")}
        return cls(Predictive(**{name: array for name, array in arrays.items() if name not in own}), **own)

    def cluster_counts(self) -> np.ndarray:
        """Posterior probability of 0, 1, 2, ... clusters, over the draws."""
        return np.bincount(self.partitions.max(axis=1) + 1) / len(self.partitions)


def fit(
    x: np.ndarray,
    settings: Mixture,
    rng: np.random.Generator,
    *,
    mean: np.ndarray | None = None,
    covariance: np.ndarray | None = None,
    state: Mapping[str, np.ndarray] | None = None,
    watch: Callable[[State], None] | None = None,
    every: int = 25,
) -> Fitted:
    """The mixture of the points x (n, d).

    `mean` (d,) and `covariance` (d, d) are what the hyperpriors measure by; default: those of x. After each `every`
    sweeps of all chains, `watch` is given a state, flat arrays by name; a later call with the same arguments, a
    generator in the same state as then and that `state` goes on from there to the same result. ParameterError for
    points that are not (n >= 1, d) and finite, or settings that keep no sweep.
    """
    x = np.asarray(x, np.float64)
    _check(x, settings)
    shift, chol, noise = _units(x, settings.resolution, mean, covariance)
    y = np.linalg.solve(chol, (x + noise * rng.standard_normal(x.shape) - shift).T).T
    chains = [Chain(y, settings, child) for child in rng.spawn(settings.chains)]
    for number, chain in enumerate(chains):
        if state is not None:
            chain.restore({name: state[f"{number}.{name}"] for name in chain.state()})
    _run(chains, watch, every)
    return _gathered(chains, shift, chol)


def _check(x: np.ndarray, settings: Mixture) -> None:
    if x.ndim != 2 or not len(x) or not np.isfinite(x).all():
        raise ParameterError(
            f"points of a mixture: expected (n >= 1, d) finite numbers, got {x.shape}, {np.isnan(x).sum()} NaN"
        )
    if settings.burn_in >= settings.sweeps:
        raise ParameterError(
            f"burn_in {settings.burn_in} leaves none of the {settings.sweeps} sweeps; give fewer or more sweeps"
        )


def _units(
    x: np.ndarray, resolution: float, mean: np.ndarray | None, covariance: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean (d,) and Cholesky factor (d, d) of the covariance the data are measured by, and the noise (d,) added to
    them.

    A column without spread is taken to have that of the widest. ParameterError if the covariance is singular.
    """
    d = x.shape[1]
    shift = x.mean(axis=0) if mean is None else np.asarray(mean, float)
    covariance = (
        (x - x.mean(axis=0)).T @ (x - x.mean(axis=0)) / len(x) if covariance is None else np.asarray(covariance, float)
    )
    spread = np.sqrt(np.diagonal(covariance))
    flat = spread <= 1e-12 * np.maximum(spread.max(initial=0.0), np.abs(x).max(axis=0, initial=0.0))
    noise = resolution * np.where(flat, spread.max(initial=0.0, where=~flat) or 1.0, spread)
    try:
        chol = np.linalg.cholesky(covariance + np.diag(noise**2))
    except np.linalg.LinAlgError:
        raise ParameterError(
            f"the covariance of {len(x)} points in {d} dimensions is singular; give a resolution above {resolution:g}"
        ) from None
    return shift, chol, noise


def _run(chains: list[Chain], watch: Callable[[State], None] | None, every: int) -> None:
    while not all(chain.is_done for chain in chains):
        threads.each(lambda chain: chain.advance(every), chains)
        if watch:
            watch({f"{c}.{name}": array for c, chain in enumerate(chains) for name, array in chain.state().items()})


def _gathered(chains: list[Chain], shift: np.ndarray, chol: np.ndarray) -> Fitted:
    d, log_det = len(shift), float(np.log(np.diagonal(chol)).sum())
    draws = [
        Predictive.of_draw(chain.x, labels, Hyperparameters.of_flat(hyper, d))
        for chain in chains
        for labels, hyper in zip(chain.kept_labels, chain.kept_hyper, strict=True)
    ]
    trace = np.array([chain.trace for chain in chains])
    trace[:, :, TRACE.index("log_joint")] -= len(chains[0].x) * log_det
    settings = chains[0].settings
    return Fitted(
        predictive=Predictive.mean(draws).affine(shift, chol),
        partitions=np.array([labels for chain in chains for labels in chain.kept_labels], np.int32),
        log_joint=trace[:, settings.burn_in :: settings.thin, TRACE.index("log_joint")].ravel(),
        trace=trace,
    )
