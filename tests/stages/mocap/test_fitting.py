"""Cells are learnt once: what was saved is taken, what is gone is missed."""

from functools import partial

import numpy as np
import pytest

from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap import training
from ipcli.models.mocap.parameters import Learning
from ipcli.params import Run
from ipcli.progress import silent
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.mocap import fitting

QUICK = Learning(mixture=Mixture(sweeps=60, burn_in=30, thin=10))
POINTS = {f"{name}, arm": np.random.default_rng(n).normal(size=(30, 2)) for n, name in enumerate(("kick", "wave"))}


def same(found, expected):
    for name, one in expected.items():
        for key, values in one.arrays().items():
            np.testing.assert_array_equal(found[name].arrays()[key], values, err_msg=f"{name}: {key}")


@pytest.mark.parametrize("executor", ["serial", "processes:2"])
def test_what_is_found_is_what_is_found_in_turn(tmp_path, executor):
    found = fitting.fit_cells(POINTS, QUICK, Run(executor=executor), Checkpoint(tmp_path / "work"), silent)
    assert list(found) == list(POINTS)
    same(found, training.fit_in_turn(POINTS, QUICK, 0))


def test_chains_that_were_cut_short_go_on_to_the_same_end(tmp_path, monkeypatch):
    work = Checkpoint(tmp_path / "work")

    def killed(name, points, settings, seed, *, state, watch):
        def save_and_die(state):
            watch(state)
            raise KeyboardInterrupt

        return training.fit_cell(name, points, settings, seed, state=state, watch=save_and_die)

    with monkeypatch.context() as patched:
        patched.setattr(fitting, "fit_cell", killed)
        with pytest.raises(KeyboardInterrupt):
            fitting.fit_cells(POINTS, QUICK, Run(), work, silent)
    assert work.load("kick, arm.chains") is not None
    starts = []

    def told(name, *arguments, state, watch):
        starts.append((name, state is not None))
        return training.fit_cell(name, *arguments, state=state, watch=watch)

    monkeypatch.setattr(fitting, "fit_cell", told)
    same(fitting.fit_cells(POINTS, QUICK, Run(), work, silent), training.fit_in_turn(POINTS, QUICK, 0))
    assert starts == [("kick, arm", True), ("wave, arm", False)]


def test_cells_that_are_done_are_not_learnt_again(tmp_path, monkeypatch):
    run = partial(fitting.fit_cells, POINTS, QUICK, Run(), Checkpoint(tmp_path / "work"), silent)
    first = run()
    monkeypatch.setattr(fitting, "fit_cell", None)
    same(run(), first)
