import numpy as np
import pytest

from ipcli.models.saliency import validation
from ipcli.models.saliency.parameters import FixationLearning, Validation
from ipcli.models.saliency.validation import Case

SHAPE = (30, 40)
PARAMS = Validation(folds=2)


def cases(count=4):
    """Channels: one that shows where the fixations are, one of noise, and what the untrained model needs."""
    made = []
    for seed in range(count):
        rng = np.random.default_rng(seed)
        at = rng.uniform((8, 8), (32, 22))
        y, x = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]]
        bump = np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / 18).astype(np.float32)
        noise = rng.normal(size=SHAPE).astype(np.float32)
        points = np.floor(rng.normal(at, 2, (24, 2))).astype(int)
        maps = {"told": bump, "noise": noise, "Boolean maps": bump, "SIFT density": bump + 0.1, "centre": noise}
        made.append(Case(f"c{seed}", maps, points, np.arange(24) % 4))
    return made


def test_fixations_come_to_the_grid_of_the_channels():
    made = validation.case(
        "a", {"x": np.zeros((15, 20), np.float32)}, np.array([[799.0, 0.0]]), np.zeros(1), (600, 800)
    )
    assert made.fixations.tolist() == [[19, 0]]
    assert made.shape == (15, 20)


def test_rows_rank_what_tells_above_noise_and_the_prior_below_the_ceiling():
    known = cases()
    found = {row.name: row for row in validation.rows(known, {}, PARAMS)}
    counts = np.full(4, 24)
    of = {name: validation.totals(row.each[None], counts)[0] for name, row in found.items()}
    assert of["told"][0] > 0.95
    assert of["noise"][0] == pytest.approx(0.5, abs=0.15)
    assert of["half of the observers"][0] > of["fixations on other pictures"][0]
    assert of["fixations on other pictures"][3] == pytest.approx(0, abs=1e-9)  # it is the baseline of the gain itself
    assert np.isnan(of["told"][3])  # a channel is no density
    assert found["half of the observers"].role == "ceiling"


def test_a_picture_is_never_judged_by_what_was_learnt_from_it(monkeypatch):
    known = cases()
    seen = []
    plain = validation.learnt_from

    def spy(ours, *args, **more):
        seen.append({c.name for c in ours})
        return plain(ours, *args, **more)

    monkeypatch.setattr(validation, "learnt_from", spy)
    maps = validation.cross_validated(known, FixationLearning(trees=2, leaf=5, negatives=40), PARAMS, 0)
    fold = validation.folds_of(4, 2, 0)
    for k in range(2):
        assert seen[2 * k] == {c.name for c, f in zip(known, fold, strict=True) if f != k}
    assert set(maps) == set(validation.FORMS)
    assert all(part.shape == SHAPE for part in maps[validation.FORMS[0]])


def test_totals_weigh_by_fixation_but_for_measures_between_maps():
    each = np.array([[[1.0] * 7, [0.0] * 7]])
    found = validation.totals(each, np.array([30, 10]))[0]
    assert found[:4] == pytest.approx([0.75] * 4)
    assert found[4:] == pytest.approx([0.5] * 3)


def test_the_halves_of_the_observers_share_no_fixation():
    one = cases(1)[0]
    kept, density = validation.ceiling(one, np.full(SHAPE, 1 / 1200), PARAMS)
    assert set(kept.observers) == {1, 3}
    assert density.sum() == pytest.approx(1)


def test_folds_differ_by_one_at_most():
    sizes = np.bincount(validation.folds_of(11, 3, 7))
    assert sizes.max() - sizes.min() == 1
