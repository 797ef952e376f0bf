"""Figure 6.3's experiment: the truth of a ball is its half thickness, the gain is the L1 fit, and a page is made."""

import sys

import numpy as np
import pytest

from experiments.animal import meshes
from experiments.animal.aspects import page
from ipcli.measurements.part_images import PartTree


def ball() -> meshes.Animal:
    import trimesh

    made = trimesh.creation.icosphere(subdivisions=4)
    labels = np.ones(len(made.faces), np.int16)
    return meshes.Animal("ball", np.array(made.vertices), np.array(made.faces), labels, PartTree(("torso",), (-1,)))


def test_the_truth_is_half_the_way_through_and_its_turned_mask_is_as_large():
    (part,) = page.parts_of(ball())
    assert part.half.max() == pytest.approx(page.LONGEST / 2, rel=0.01)
    assert part.turned.sum() == pytest.approx(part.mask.sum(), rel=0.01)
    assert part.diagonal == pytest.approx(page.LONGEST * np.sqrt(3), rel=0.01)


def test_the_gain_is_the_factor_that_was_taken_away():
    (part,) = page.parts_of(ball())
    assert page.gain([part], [part.half / 1.7]) == pytest.approx(1.7)
    assert page.error(part, part.half) == 0.0


@pytest.mark.slow
def test_the_quick_form_makes_a_page(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["page", str(tmp_path / "index.html"), "--quick"])
    page.main()
    assert "sqrt-poisson" in capsys.readouterr().out
    assert "What lifts a mask" in (tmp_path / "index.html").read_text(encoding="utf-8")
