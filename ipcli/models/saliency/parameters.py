"""Parameters of the saliency of pictures and surfaces."""

from __future__ import annotations

from dataclasses import dataclass

from ipcli.params import option


@dataclass(frozen=True)
class FixationLearning:
    """How a predictor is learnt."""

    inverse_ridge: float = option(0.01, "Inverse weight of the ridge of the logistic regression.", low=1e-9)
    trees: int = option(150, "Boosted trees beside the logistic regression; 0: none.", flag="--trees", low=0)
    depth: int = option(3, "Most questions from the root of a tree to a leaf.", low=1, high=10)
    rate: float = option(0.03, "Share of each tree that is kept.", low=1e-4, high=1.0)
    leaf: int = option(50, "Fewest rows in a leaf.", low=1)
    share: float = option(0.5, "Share of the features that each split may look at.", low=0.01, high=1.0)
    negatives: int = option(600, "Places drawn from a picture as not looked at.", low=10)


@dataclass(frozen=True)
class Validation:
    """How predictors are judged."""

    folds: int = option(5, "Folds of the cross-validation; each picture or surface is in one.", flag="--folds", low=2)
    blur: float = option(0.03, "Spread of the blurred map of fixations, as a share of the picture's width.", low=1e-4)
