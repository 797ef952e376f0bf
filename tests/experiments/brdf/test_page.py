"""The tables of the experiments of chapter 7 on made-up errors, and objects of our own that are in one piece."""

from dataclasses import fields, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import label

from experiments.brdf import development, page, painted, reliefs, scenes
from experiments.brdf.scenes import Case
from ipcli.models.brdf.grid import normals
from ipcli.models.brdf.parameters import Inference
from ipcli.models.brdf.surfaces import ImplicitSurface
from ipcli.rng import stream

AXIS = np.linspace(-1, 1, 12)
HILL = 1.5 - np.hypot(*np.meshgrid(AXIS, AXIS)) ** 2
NONE = [0.3, 0.3, 2.0, np.nan]
own = cache(scenes.own)
ORACLES = {"true rim": NONE, "true map, as a solid": NONE}
ROWS = {
    "a": {"flat": [0.8, 0.8, 9.0, np.nan], "inflation": [0.2, 0.2, 4.0, np.nan], "ours": [0.1, 0.1, 1.0, 3.0]}
    | ORACLES,
    "b": {"flat": [0.2, 0.2, 1.0, np.nan], "inflation": [0.2, 0.2, 1.0, np.nan], "ours": [0.4, 0.3, 4.0, 5.0]}
    | ORACLES,
}


def test_means_are_geometric_for_mit_and_count_what_is_worse():
    lines = {line[0]: line for line in page.summary("mit", ROWS)}
    assert lines["ours"][1] == "0.2"
    assert lines["ours"][3] == "2"
    assert lines["ours"][4:] == ["+0 %", "1 of 2"]
    lines = {line[0]: line for line in page.summary("diligent", ROWS)}
    assert lines["ours"][1] == "0.25"


def test_an_ablation_changes_one_thing():
    asked = page.ablations(Inference())
    ours = asked.pop("always a solid")
    assert ours == replace(Inference(), rim="solid")
    weights = asked["no forces (prior normals), as a solid"].solid.weights
    assert (weights.normal, weights.bending) == (0.0, ours.solid.weights.bending)
    for other in asked.values():
        assert sum(getattr(other, f.name) != getattr(ours, f.name) for f in fields(Inference)) == 1


def test_methods_that_are_named_are_measured_alone(monkeypatch):
    monkeypatch.setattr(page, "reconstruct", lambda colour, mask, shelf, params: SimpleNamespace(height=HILL))
    case = Case("hill", "hill", np.ones((12, 12, 3)), HILL > 0, normals(HILL, HILL > 0), HILL)
    found = page.measured(case, None, Inference(), ("always a solid",))
    assert list(found) == ["flat", "inflation", "always a solid"]
    assert found["always a solid"][0] < 1e-6 < found["flat"][0]


def test_what_was_measured_is_written(tmp_path):
    page.write(tmp_path, "mit", ROWS, {"a": "x", "b": "y"}, dict.fromkeys(ROWS, "All cases"))
    assert len((tmp_path / "errors.csv").read_text().splitlines()) == 11
    assert "NaN" not in (tmp_path / "errors.json").read_text()
    assert "worse by 2" in (tmp_path / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["boot", "moka pot", "dish", "teapot", "vase"])
def test_objects_of_our_own_are_whole(name):
    made = own(64)[name]
    assert label(made.mask)[1] == 1
    assert made.mask.mean() > 0.1
    assert np.isfinite(made.height[made.mask]).all()


def test_a_further_draw_is_the_same_objects_in_other_light_summed_up_by_itself(monkeypatch):
    hill = ImplicitSurface(HILL > 0, HILL, normals(HILL, HILL > 0), False, "hill")
    monkeypatch.setattr(scenes, "own", lambda side: {"hill": hill, "mound": hill})
    light = np.random.default_rng(0).uniform(size=(6, 9, 9, 3))
    shelf = SimpleNamespace(charts=light, material=np.zeros(6, int), materials=("tin",))
    first, again = (list(page.synthetic(shelf, np.array([True]), True, draws)) for draws in (1, 2))
    assert [case.kind for case in again] == ["Metals", "Metals", "Metals, draw 2", "Metals, draw 2"]
    assert len({case.name for case in again}) == 4
    np.testing.assert_array_equal(again[0].colour, first[0].colour)
    assert np.abs(again[2].colour - first[0].colour).max() > 0.1


def test_development_sums_up_generated_solids_by_themselves_and_leaves_out_generated_sheets(monkeypatch):
    def of(name):
        return Case(name, "", np.ones((12, 12, 3)), HILL > 0, normals(HILL, HILL > 0), HILL)

    monkeypatch.setattr(development, "cases", lambda data: iter([of("spot pvc")]))
    monkeypatch.setattr(development, "generated_cases", lambda data, count: iter([of("sheet pvc"), of("vase pvc")]))
    found = [(case.name, case.kind) for case in development.with_solids(None)]
    assert found == [("spot pvc", "All cases"), ("generated vase pvc", "Generated solids")]


@pytest.mark.parametrize(("sign", "tie", "is_told"), [(-1, 0.0, True), (-1, 0.5, False), (1, 0.0, False)])
def test_the_sign_is_told_of_what_is_hollow_where_the_picture_ties(monkeypatch, sign, tie, is_told):
    asked = []

    def made(colour, mask, shelf, params):
        asked.append(params.relief)
        return SimpleNamespace(height=HILL, prior=HILL, solid_height=HILL, sheet_height=HILL, tie=tie)

    monkeypatch.setattr(page, "reconstruct", made)
    case = Case("", "", np.ones((12, 12, 3)), HILL > 0, normals(sign * HILL, HILL > 0), sign * HILL)
    found = page.measured(case, None, Inference(), ("ours",))
    assert asked == ["convex", "concave"][: 1 + is_told]
    assert "sign told where it ties" in found


@pytest.mark.parametrize("paint", painted.PAINTS)
def test_paint_darkens_and_only_marble_has_no_edges(paint):
    albedo = painted.albedo(paint, (80, 100), stream(1, "paint", paint))
    assert albedo.shape == (80, 100, 3)
    assert 0.3 <= albedo.min() < 0.6 < 0.8 < albedo.max() <= 1
    steps = np.abs(np.diff(albedo, axis=1)).max()
    assert (steps < 0.2) == (paint == "marble")


def test_a_bowl_is_the_cast_of_its_dome_and_either_is_on_the_right_side_of_itself():
    outline = next(reliefs.outlines())
    dome, bowl = reliefs.relief(outline, True), reliefs.relief(outline, False)
    np.testing.assert_allclose(bowl.height, -dome.height)
    assert reliefs.right_side(dome.height, dome) == reliefs.right_side(3 * bowl.height + 7, bowl) == 1
    assert reliefs.right_side(dome.height, bowl) == 0


def test_hollow_things_are_whole_and_mostly_hollow_and_the_handle_of_the_spoon_bulges():
    made = {one.name: one for one in reliefs.hollow()}
    assert all(label(one.mask)[1] == 1 for one in made.values())
    hollow = {name: reliefs.right_side(-np.nan_to_num(page.grid.inflate(one.mask)), one) for name, one in made.items()}
    assert hollow["dish"] > 0.95
    assert hollow["bowl"] > 0.95
    assert 0.6 < hollow["spoon"] < 0.95


def test_relief_under_light_from_above_is_told_and_written(tmp_path):
    dome = reliefs.Told(reliefs.CASTS, "dome", "above", 0.9, 1.0, True)
    found = [dome, reliefs.Told(reliefs.HOLLOW, "bowl", "side", 0.2, 0.0, False)]
    page.write_reliefs(tmp_path, found)
    assert len((tmp_path / "reliefs.csv").read_text().splitlines()) == 3
    assert "90 %" in (tmp_path / "index.html").read_text(encoding="utf-8")
