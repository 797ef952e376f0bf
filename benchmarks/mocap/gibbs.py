"""Samplers and fits of Gaussian mixtures of unknown size, side by side on planted clusters.

    python -m benchmarks.mocap.gibbs [--quick]

Each row runs in a process of its own, on one thread; see README.md for what the tables say.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import Clock, attempted, best_of, installed, isolated
from benchmarks.kit.publish import publish, say

CASES = ((800, 10, 7), (2000, 20, 7), (800, 10, 20), (800, 10, 50))  # points, planted clusters, dimensions
HELD_OUT = 2000
SWEEPS = 100
SLOW_SWEEPS = 10  # of dpmmlearn
MODELS = 66  # 11 actions of 6 groups
MODEL_POINTS = 800
WORKERS = 2
DRAWS = (1, 2, 5, 10)  # kept sweeps that a density averages
PEERS = {"scikit-learn BayesianGaussianMixture": "sklearn", "dpmmlearn (Neal's Algorithm 2)": "dpmmlearn"}


def planted(n: int, k: int, d: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, d) of k Gaussians of unlike shapes in units of their standard deviation, their labels, and points held
    out.
    """
    rng = np.random.default_rng(seed)
    labels = rng.integers(k, size=n + HELD_OUT)
    centres, roots = 3 * rng.normal(size=(k, d)), rng.normal(size=(k, d, d)) / np.sqrt(d)
    x = centres[labels] + np.einsum("nij,nj->ni", roots[labels], rng.normal(size=(n + HELD_OUT, d)))
    x = (x - x[:n].mean(axis=0)) / x[:n].std(axis=0)
    return x[:n], labels[:n], x[n:]


def _row(
    n: int, passes: int, seconds: float, labels: np.ndarray, truth: np.ndarray, held_out: float | None
) -> dict[str, Any]:
    from ipcli.inverse.bayes.partitions import variation_of_information

    return {
        "points x sweeps a second": n * passes / seconds,
        "sweeps": passes,
        "seconds": seconds,
        "large clusters": int(np.sum(np.bincount(labels) > 0.01 * n)),
        "VI to the truth": variation_of_information(labels, truth),
        "held-out log density": held_out,
    }


def ours(n: int, k: int, d: int, sweeps: int) -> dict[str, Any]:
    """A whole fit at the defaults, from the over-segmented start to the averaged density."""
    from ipcli.inverse.bayes.mixture import fit
    from ipcli.inverse.bayes.parameters import Mixture

    x, truth, rest = planted(n, k, d)
    fit(x[:50], Mixture(sweeps=3, burn_in=1), np.random.default_rng(0)).predictive.log_density(rest)  # compiles
    clock = Clock()
    with clock:
        fitted = fit(x, Mixture(sweeps=sweeps, burn_in=sweeps // 2), np.random.default_rng(1))
    return _row(n, sweeps, clock.last, fitted.labels(), truth, float(fitted.predictive.log_density(rest).mean()))


def our_sweep(n: int, k: int, d: int, sweeps: int) -> dict[str, Any]:
    """Gibbs sweeps alone, of a chain that has settled."""
    from ipcli.inverse.bayes.chain import Chain
    from ipcli.inverse.bayes.parameters import Mixture
    from ipcli.kernels import dirichlet

    x, truth, _ = planted(n, k, d)
    chain, clock = Chain(x, Mixture(sweeps=1000), np.random.default_rng(1)), Clock()
    chain.advance(50)
    base = chain.base()
    with clock:
        for _ in range(sweeps):
            dirichlet.sweep(chain.x, chain.labels, chain.clusters, *base, chain.rng)
    return _row(n, sweeps, clock.last, chain.labels, truth, None)


def sklearn(n: int, k: int, d: int, sweeps: int) -> dict[str, Any]:
    """Variational, 2 k components at the most, its Dirichlet process prior and the prior covariance with the best
    density.
    """
    from sklearn.mixture import BayesianGaussianMixture

    x, truth, rest = planted(n, k, d)
    found, clock = [], Clock()
    for share in (1.0, 0.1, 0.01):
        model = BayesianGaussianMixture(
            n_components=2 * k, covariance_prior=share * np.eye(d), max_iter=500, random_state=0
        )
        with clock:
            model.fit(x)
        found.append((float(model.score(rest)), clock.last, model))
    held_out, seconds, model = max(found, key=lambda one: one[0])
    return _row(n, model.n_iter_, seconds, model.predict(x), truth, held_out)


def dpmmlearn(n: int, k: int, d: int, sweeps: int) -> dict[str, Any]:
    """From k-means++ labels as ours starts; the prior covariance in {1, 0.1, 0.01} of the data's that comes nearest to
    the truth.
    """
    from dpmmlearn import DPMM
    from dpmmlearn.probability import NormInvWish

    from ipcli.inverse.bayes.partitions import variation_of_information

    x, truth, _ = planted(n, k, d)
    found, clock = [], Clock()
    for share in (1.0, 0.1, 0.01):
        prior = NormInvWish(np.zeros(d), 0.1, share * np.eye(d), d + 2)
        model = DPMM(prior, 1.0, max_iter=min(sweeps, SLOW_SWEEPS), random_state=0, verbose=False)
        with clock:
            labels = np.unique(model.fit_predict(x), return_inverse=True)[1]
        found.append((variation_of_information(labels, truth), clock.last, labels))
    _, seconds, labels = min(found, key=lambda one: one[0])
    return _row(n, min(sweeps, SLOW_SWEEPS), seconds, labels, truth, None)


def learn_one(name: str, sweeps: int) -> int:
    """One of the many models; the number of its clusters."""
    from ipcli.inverse.bayes.mixture import fit
    from ipcli.inverse.bayes.parameters import Mixture

    x, _, _ = planted(MODEL_POINTS, 10, 7, seed=int(name))
    return int(fit(x, Mixture(sweeps=sweeps, burn_in=sweeps // 2), np.random.default_rng(int(name))).labels().max()) + 1


def many(models: int, sweeps: int) -> list[dict[str, Any]]:
    """Seconds for so many models, by one process and by two, start of the processes included."""
    from ipcli.executor import map_items

    rows, names = [], [str(number) for number in range(models)]
    learn_one("0", 3)  # compiles
    for executor in ("serial", f"processes:{WORKERS}"):
        clock = Clock()
        with clock:
            map_items(partial(learn_one, sweeps=sweeps), names, executor)
        rows.append(
            {"executor": executor, "models": models, "points": MODEL_POINTS, "sweeps": sweeps, "seconds": clock.last}
        )
    return rows


def density(n: int, k: int, d: int) -> list[dict[str, Any]]:
    """Seconds of the predictive density against the number of draws it averages, and what averaging is worth."""
    from ipcli.inverse.bayes.mixture import fit
    from ipcli.inverse.bayes.parameters import Mixture

    x, _, rest = planted(n, k, d)
    predictive = fit(x, Mixture(), np.random.default_rng(1)).predictive
    frames, rows = np.tile(rest, (10, 1)), []
    predictive.log_density(rest)
    for draws in DRAWS:
        few = predictive.thinned(draws)
        took, found = best_of(3, partial(few.log_density, frames))
        seconds = took / len(frames)
        rows.append(
            {
                "draws": draws,
                "components": len(few.dof),
                "ns a point and component": 1e9 * seconds / len(few.dof),
                f"million points a minute, {MODELS} models": 60 / (seconds * MODELS) / 1e6,
                "held-out log density": float(found.mean()),
            }
        )
    return rows


def compare(cases: tuple[tuple[int, int, int], ...], sweeps: int) -> dict[str, list[dict[str, Any]]]:
    """A table a case, a row a method."""
    methods = {"ipcli, sweeps alone": "our_sweep", "ipcli, whole fit": "ours"}
    methods |= {title: module for title, module in PEERS.items() if installed(title, module)}
    tables: dict[str, list[dict[str, Any]]] = {}
    for n, k, d in cases:
        heading = f"{n} points, {k} planted clusters, {d} dimensions"
        tables[heading] = []
        for title, function in methods.items():
            say(f"{heading}: {title}")
            row = attempted(f"benchmarks.mocap.gibbs:{function}", 1, n=n, k=k, d=d, sweeps=sweeps)
            tables[heading].append({"method": title} | row)
    return tables


def main(arguments: list[str] | None = None) -> None:
    """Measure, write and print."""
    options = parser_of(__doc__, "one small case, few models").parse_args(arguments)
    cases, sweeps, models = (((200, 4, 3),), 20, 4) if options.quick else (CASES, SWEEPS, MODELS)
    tables = compare(cases, sweeps)
    say(f"{models} models")
    tables["Many models"] = isolated("benchmarks.mocap.gibbs:many", 1, models=models, sweeps=sweeps)
    tables["Density"] = isolated("benchmarks.mocap.gibbs:density", 1, n=cases[0][0], k=cases[0][1], d=cases[0][2])
    publish("bayes_gibbs", "Dirichlet process mixtures of Gaussians", tables, {"sweeps": sweeps}, options.output)


if __name__ == "__main__":
    main()
