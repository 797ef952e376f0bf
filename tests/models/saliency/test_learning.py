import numpy as np
import pytest

from ipcli.models.saliency.learning import Predictor, learn
from ipcli.models.saliency.parameters import FixationLearning

RNG = np.random.default_rng(5)
ROWS = RNG.normal(size=(600, 3)).astype(np.float32)
LABELS = ((ROWS[:, 0] > 0) ^ (ROWS[:, 1] > 0.5)).astype(int)
QUICK = FixationLearning(trees=12, leaf=10, share=1.0)


def test_scores_of_the_arrays_are_those_of_scikit_learn():
    from sklearn.ensemble import HistGradientBoostingClassifier

    made = learn(ROWS, LABELS, "abc", QUICK, seed=2)
    theirs = HistGradientBoostingClassifier(
        max_iter=12, max_depth=3, learning_rate=0.03, min_samples_leaf=10, l2_regularization=1.0, max_features=1.0,
        early_stopping=False, random_state=2,
    ).fit(ROWS, LABELS)  # fmt: skip
    assert made.boosting is not None
    assert made.boosting.scores(ROWS) == pytest.approx(theirs.decision_function(ROWS), abs=1e-6)


def test_trees_learn_what_no_line_parts():
    made = learn(ROWS, LABELS, "abc", FixationLearning(trees=60, leaf=10, rate=0.1))
    right = ((made.boosting.scores(ROWS) > 0) == LABELS).mean()
    assert right > 0.95


def test_a_predictor_survives_as_plain_arrays():
    for trees in (0, 12):
        made = learn(ROWS, LABELS, "abc", FixationLearning(trees=trees, leaf=10))
        arrays = made.arrays()
        assert all(isinstance(part, np.ndarray) and part.dtype.kind in "fiU" for part in arrays.values())
        assert np.array_equal(Predictor.of(arrays).scores(ROWS), made.scores(ROWS))
