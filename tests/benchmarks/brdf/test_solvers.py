"""Solvers of one energy come to one end, and the rows say what it took."""

import pytest

from benchmarks.brdf import solvers


@pytest.fixture(scope="module")
def rows():
    with pytest.MonkeyPatch.context() as few:
        few.setattr(solvers, "STEPS", (8, 32))
        few.setattr(solvers, "ITERATIONS", (256, 512))
        found = solvers.solvers(24)
    return {row["solver"]: row for row in found}


def test_the_peer_finds_no_lower_energy_and_both_are_far_below_the_start(rows):
    ours, peer = rows["Gauss-Newton"], rows["L-BFGS (SciPy)"]
    assert ours["energy"] == pytest.approx(peer["energy"], rel=0.01)
    assert ours["near the least"] == peer["near the least"] == "yes"
    assert ours["times"] == 1


def test_the_convex_refinement_minimises_terms_of_its_own(rows):
    assert rows["convex, with TGV"]["energy"] > rows["Gauss-Newton"]["energy"]
