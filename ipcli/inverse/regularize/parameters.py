"""Parameters of the regulariser and of its solver, declared once for flags, configuration files and provenance."""

from __future__ import annotations

from dataclasses import dataclass

from ipcli.params import option


@dataclass(frozen=True)
class Regulariser:
    """alpha1 |grad x - v| + alpha0 |E v| minimised over v for order 2, alpha1 |grad x| for order 1."""

    order: int = option(2, "2: piecewise affine (TGV); 1: piecewise constant (TV)", low=1, high=2)
    alpha1: float = option(1.0, "weight of the first-order term |grad x - v|", low=0.0)
    alpha0: float = option(2.0, "weight of the second-order term |E v|", low=0.0)


@dataclass(frozen=True)
class Solver:
    """The primal-dual iteration and when it stops."""

    tolerance: float = option(1e-3, "stop at this relative primal-dual gap", flag="--tolerance", low=0.0)
    iterations: int = option(500, "iterations at the most, per round", low=1)
    check: int = option(50, "iterations between two looks at the gap", low=1)
    primal_weight: float = option(0.0, "dual over primal step; 0: 150 over the spread of the image", low=0.0)
    relaxation: float = option(1.7, "over-relaxation in (0, 2)", low=0.1, high=1.99)
    levels: int = option(4, "levels of the coarse-to-fine start; 1 starts at the median", low=1)
    level_iterations: int = option(100, "iterations on each coarser level", low=1)
