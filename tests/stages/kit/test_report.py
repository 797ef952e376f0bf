"""`ipcli report` on files."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from ipcli.cli.report import main
from ipcli.errors import FormatError, OutputExists, ParameterError
from ipcli.io.files import h5
from ipcli.params import Run
from ipcli.stages.kit import report
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.kit.report import Params


@pytest.fixture
def fused(tmp_path, artefact, provenance):
    path = tmp_path / "fused.h5"
    h5.write(path, "fused-depth", artefact, provenance)
    return path


def test_made_once_then_up_to_date_and_never_replaced_unasked(fused, artefact, provenance):
    page = fused.with_suffix(".html")
    assert report.run(fused, page, Params(), Run(dry_run=True)) is Outcome.WOULD_RUN
    assert not page.exists()
    assert report.run(fused, page, Params(), Run()) is Outcome.DONE
    first = page.read_bytes()
    assert report.run(fused, page, Params(), Run()) is Outcome.UP_TO_DATE
    page.write_text("notes of my own")
    with pytest.raises(OutputExists, match="--overwrite"):
        report.run(fused, page, Params(), Run())
    assert report.run(fused, page, Params(), Run(overwrite=True)) is Outcome.DONE
    assert page.read_bytes() == first


def test_the_file_gives_the_page_of_its_arrays(fused, artefact, provenance):
    from ipcli.report.fusion import fused_depth

    assert report.render(fused, Params(width=40)) == fused_depth.page(artefact, provenance, widest=40)


def test_views_have_a_page_too(tmp_path, views_artefact, provenance):
    path = tmp_path / "sequence.views.h5"
    h5.write(path, "views", views_artefact, provenance)
    assert "Contact sheet" in report.render(path, Params())


def test_an_artefact_is_never_replaced_by_its_page(fused):
    with pytest.raises(ParameterError, match="would replace the artefact"):
        report.run(fused, fused, Params(), Run(overwrite=True))


def test_a_file_that_is_no_artefact_is_refused(tmp_path):
    stray = tmp_path / "notes.h5"
    stray.write_text("no artefact")
    with pytest.raises(FormatError, match="notes.h5"):
        report.run(stray, tmp_path / "page.html", Params(), Run())
    assert list(tmp_path.iterdir()) == [stray]


def test_the_command_prints_where_the_page_is(fused):
    result = CliRunner().invoke(main, [str(fused), "--json", "--width", "100"], catch_exceptions=False)
    assert result.exit_code == 0
    assert json.loads(result.stdout) == {"output": str(fused.with_suffix(".html")), "outcome": "done"}
