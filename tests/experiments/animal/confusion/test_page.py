"""Which kind is nearest: distances of boxes that are known, and who is left out."""

import numpy as np
import pytest
import trimesh

from experiments.animal.confusion import page


def box(*sides):
    body = trimesh.creation.box(sides)
    return np.array(body.vertices) + 3.0, np.array(body.faces)


def test_boxes_of_one_shape_lie_on_each_other_and_stretched_all_do():
    first, second, other = box(1, 2, 3), box(2, 4, 6), box(3, 1, 1)
    apart = page.distances(*([page.boxed(mesh, False) for mesh in group] for group in ([first], [second, other])))
    assert apart[0, 0] == pytest.approx(0, abs=1e-9)
    assert apart[0, 1] > 0.05
    stretched = page.distances(*([page.boxed(mesh, True) for mesh in group] for group in ([first], [other])))
    assert stretched[0, 0] == pytest.approx(0, abs=1e-9)


def test_own_kind_with_itself_and_without():
    apart = np.array([[0.1, 0.3, 0.2], [0.3, 0.1, 0.4], [0.2, 0.5, 0.1]])
    names, kinds = ["a", "b", "c"], ["horse", "horse", "cow"]
    assert page.nearest(apart, names, kinds, is_alone=False) == ["horse", "horse", "cow"]
    assert page.nearest(apart, names, kinds, is_alone=True) == ["cow", "horse", None]  # no other cow
    rows = page.rows_of(dict.fromkeys(page.BOXES, apart), names, kinds)
    assert "2 of 2" not in page.page(dict.fromkeys(page.BOXES, apart), rows)
    assert "3 of 3" in page.page(dict.fromkeys(page.BOXES, apart), rows)
