"""The whole pages: what holds for every page, whatever the artefact lacks."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import ParameterError
from ipcli.report import needed, renderer
from ipcli.report.fusion import accuracy, fused_depth, views
from tests.fixtures.pages import ESCAPED, HOSTILE, decoded, sound
from tests.fixtures.report_artefacts import fused_artefact

TRUTH = ("truth", "metrics", "metric_rows", "metric_columns")


def without(artefact, *names):
    return {name: array for name, array in artefact.items() if name not in names}


def variants():
    full = fused_artefact()
    blank = np.full_like(full["depth"], np.nan)
    yield "full", full
    yield "no truth", without(full, *TRUTH)
    yield "no image", without(full, "image")
    yield "neither", without(full, "image", *TRUTH)
    yield "one view", without(fused_artefact(k=1), "image", *TRUTH)
    yield "wide", fused_artefact(30, 99, 4)
    yield "tall", fused_artefact(90, 40, 3)
    yield "tiny", without(fused_artefact(2, 3, 2), "image", *TRUTH)
    yield "single pixel", without(fused_artefact(1, 1, 1), *TRUTH)
    yield "no confidence", full | {"confidence": blank}
    yield "zero confidence", full | {"confidence": np.zeros_like(blank)}
    yield (
        "nothing fused",
        full | {"depth": blank, "normals": np.full_like(full["normals"], np.nan), "confidence": blank},
    )
    yield (
        "no observation",
        full
        | {"median": blank, "mean": blank, "reference": blank, "observations": np.zeros_like(full["observations"])},
    )
    yield "empty truth", full | {"truth": blank}
    yield "no history", full | {"history": np.empty((0, 5))}
    yield "no gap", full | {"history": np.array([[0, 1, np.nan, np.nan, np.nan]])}
    yield (
        "no overlap",
        full
        | {
            "view_overlap": np.zeros(5),
            "view_residual": np.full(5, np.nan),
            "thumbnails": np.full((5, 4, 4), np.nan, np.float32),
        },
    )
    yield "disparity", full | {"domain": np.array("disparity"), "unit": np.array("")}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("name", "arrays"), [pytest.param(*variant, id=variant[0].replace(" ", "-")) for variant in variants()]
)
def test_every_variant_makes_a_sound_page(name, arrays, provenance):
    sound(fused_depth.page(arrays, provenance))


def test_the_synthetic_artefact_is_a_valid_one(artefact):
    schema.validate(schema.kind("fused-depth"), artefact)


def test_hostile_names_come_out_escaped(artefact, provenance, views_artefact):
    hostile = artefact | {
        "unit": np.array(HOSTILE),
        "method": np.array(HOSTILE),
        "metric_rows": np.array([HOSTILE, '"><b>']),
        "metric_columns": np.array([HOSTILE, "x' onerror='"]),
    }
    for html in (fused_depth.page(hostile, provenance), views.page(views_artefact, provenance)):
        sound(html)
        assert ESCAPED in html
        assert "<script" not in html


def test_the_same_artefact_gives_the_same_bytes(artefact, provenance):
    order = dict(reversed(artefact.items()))
    assert fused_depth.page(artefact, provenance) == fused_depth.page(order, provenance)


def test_the_page_tells_size_views_error_and_little_overlap(artefact, provenance):
    html = fused_depth.page(artefact, provenance)
    verdict = re.search(r'class="verdict">(.*?)</p>', html)[1]
    for words in ("64 × 48 pixels", "5 views", "λ = 0.6", "0.03\N{NO-BREAK SPACE}m", "mean error 0.002"):
        assert words in verdict
    assert "1 of 5 views overlaps the reference by less than 5\N{NO-BREAK SPACE}%" in html
    assert html.count('class="warn"') == 1
    assert "solver.gap" in html
    assert "ab" * 32 in html
    assert "a&amp;b.h5" in html


def test_sections_about_the_truth_come_only_with_it(artefact, provenance):
    assert "Against the truth" in fused_depth.page(artefact, provenance)
    assert "Against the truth" not in fused_depth.page(without(artefact, *TRUTH), provenance)


def test_a_full_size_page_is_small_and_quick(large, provenance):
    fused_depth.page(fused_artefact(), provenance)  # imports and palettes
    started = time.process_time()
    html = fused_depth.page(large, provenance)
    assert time.process_time() - started < 1.0
    assert len(html.encode()) < 2.5e6
    assert all(decoded(picture["src"]).shape[1] <= 900 for picture in sound(html).pictures)


def test_pictures_are_no_wider_than_asked_for(large, provenance):
    page = sound(fused_depth.page(large, provenance, widest=200))
    assert max(int(picture.get("width", 0)) for picture in page.pictures) <= 200


def test_the_enlarged_window_is_where_the_error_is(artefact):
    artefact["depth"][30:36, 40:46] += 1
    row, column, height, width = fused_depth._window(artefact)
    assert row <= 30
    assert row + height >= 36
    assert column <= 40
    assert column + width >= 46


def test_the_best_of_each_metric_is_marked():
    values = np.array([[0.3, 90, np.nan], [0.1, 95, np.nan], [0.1, 80, np.nan]])
    assert accuracy.best(values, ["MAE", "density, %", "RMSE"]) == {(1, 1), (2, 1), (1, 2)}


def test_iterations_go_on_over_rounds_that_count_anew():
    assert fused_depth.unwrap(np.array([10, 20, 10, 20, 30, 5.0])).tolist() == [10, 20, 30, 40, 50, 55]
    assert fused_depth.unwrap(np.array([10, 20, 30.0])).tolist() == [10, 20, 30]


def test_the_contact_sheet_shows_all_views_in_order(views_artefact, provenance):
    schema.validate(schema.kind("views"), views_artefact)
    kept = {name: array for name, array in views_artefact.items() if needed("views")(name)}
    html = views.page(kept, provenance)
    assert len([picture for picture in sound(html).pictures if "width" in picture]) == 6
    assert html.index(">a</b>") < html.index(">b</b>")
    assert html == views.page(views_artefact, provenance)  # what is left unread is not shown
    assert "3 views of 3 sizes" in html


def test_a_long_sequence_is_sampled_evenly():
    names = [f"{index:04d}" for index in range(1000)]
    shown = views.spread(names, views.MOST)
    assert len(shown) == len(set(shown)) == views.MOST
    assert (shown[0], shown[-1]) == ("0000", "0999")
    sound(views.page({"unit": np.array("m"), "measured": np.array("depth")}, {}))


def test_a_kind_without_a_page_is_refused():
    with pytest.raises(ParameterError, match="no report for artefacts of kind 'notes'.*fused-depth,.* views"):
        renderer("notes")
