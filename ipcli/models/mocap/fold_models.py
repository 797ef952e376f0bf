"""Models of all but a part of the people each, that judge together whether a query is none of the actions.

    judges = FoldModels.of_folds(folds, decision)                                 # when learning
    densities = judges.log_densities(features)                                    # of frames that are asked about
    asked = judges.measured(densities, query, queries, decision, ordered=True)
    novelty = judges.references[True].novelty(asked)                              # (q,), of whole clips

Parts of clips say less than whole ones. Of them only the surprise of held-out parts is kept, for the model of all
people.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.mocap import behaviours, recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.calibration import PREFIXES, Fold, Reference
from ipcli.models.mocap.novelty import Measured, measure
from ipcli.models.mocap.parameters import Decision

PART = 5  # frames of the parts of clips that surprise is known of; fewer are not judged as whole clips are


@dataclass(frozen=True, eq=False)
class FoldModels:
    """The model of each fold, and what clips held out of it are like."""

    models: tuple[Model, ...]
    references: Mapping[bool, Reference]  # of recordings in order (True) and of poses alone, where there are any
    surprise: np.ndarray  # (v,), how unlike the poses of its best action each part of a held-out clip is, ascending

    @classmethod
    def of_folds(cls, folds: Sequence[Fold], decision: Decision) -> FoldModels:
        """Calibrate on the clips that were held out of each fold."""
        made = {ordered: Reference.of_folds(folds, decision, ordered=ordered) for ordered in PREFIXES}
        parts = [surprise(fold.model, fold.log_density, _parts(fold.query), decision) for fold in folds]
        every = np.concatenate([*parts, np.empty(0)])
        return cls(
            tuple(fold.model for fold in folds),
            {ordered: one for ordered, one in made.items() if one is not None},
            np.sort(every[np.isfinite(every)]),
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """The models and calibrations as flat arrays; `of_arrays` is the inverse."""
        found = behaviours.fold_arrays(self.models) if self.models else {}
        for ordered, one in self.references.items():
            found |= one.arrays(PREFIXES[ordered])
        return found | {"novelty": self.surprise}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, np.ndarray]) -> FoldModels:
        """The models and calibrations that `arrays` wrote, in a `behaviours` artefact."""
        groups = tuple(map(str, arrays["groups"]))
        made = {ordered: Reference.of_arrays(groups, arrays, prefix) for ordered, prefix in PREFIXES.items()}
        found = {ordered: one for ordered, one in made.items() if one is not None}
        return cls(behaviours.of_fold_arrays(arrays), found, arrays["novelty"])

    def log_densities(self, features: Mapping[str, np.ndarray], *, ordered: bool = True) -> list[np.ndarray]:
        """log densities (f, a, g) of frames by each model, from features (f, D) by name of group; those of motion not
        known if the frames are not `ordered`.
        """
        each = [recognition.log_densities(model, features) for model in self.models]
        return each if ordered else [recognition.poses_alone(*one) for one in zip(self.models, each, strict=True)]

    def measured(
        self, densities: Sequence[np.ndarray], query: np.ndarray, queries: int, decision: Decision, *, ordered: bool
    ) -> list[Measured]:
        """What each model says about queries, from its densities (f, a, g) of their frames; query (f,) int, the query
        of each frame.
        """
        return [
            measure(model, density, query, queries, decision, ordered=ordered)
            for model, density in zip(self.models, densities, strict=True)
        ]


def surprise(
    model: Model, log_density: np.ndarray, query: np.ndarray, decision: Decision, queries: int | None = None
) -> np.ndarray:
    """How unlike those of its best action the poses of each query are, (q,), from log densities (f, a, g) of frames."""
    count = int(query.max(initial=-1)) + 1 if queries is None else queries
    posterior = recognition.frame_posteriors(model, log_density, decision)
    return recognition.answer(posterior, recognition.novelty_scores(model, log_density), query, count, decision).novelty


def _parts(clip: np.ndarray) -> np.ndarray:
    """Number (f,) of the part of each frame: each clip (f,) in parts of PART frames or more, spread along it.

    Parts, as a clip of many frames is less surprising by chance than a few of them.
    """
    _, first, index, count = np.unique(clip, return_index=True, return_inverse=True, return_counts=True)
    parts = np.maximum(count // PART, 1)
    return (np.cumsum(parts) - parts)[index] + (np.arange(len(clip)) - first[index]) % parts[index]
