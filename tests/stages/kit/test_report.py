"""`ipcli report` on files."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from ipcli.cli.report import main
from ipcli.errors import FormatError, OutputExists, OutputRefused, ParameterError
from ipcli.io.files import h5
from ipcli.params import Run
from ipcli.report.kit.page import with_turning_page
from ipcli.stages.kit import report
from ipcli.stages.kit.artefact import Outcome
from ipcli.stages.kit.parameters import Report
from tests.fixtures.fusion_scenes import scene, write
from tests.fixtures.report_artefacts import fused_artefact

PROVENANCE = {"command": "fuse-depth", "ipcli": "0.1.0", "params": {}, "seed": 0, "inputs": [], "digest": "cd" * 32}


@pytest.fixture
def fused(tmp_path):
    path = tmp_path / "fused.h5"
    h5.write(path, "fused-depth", fused_artefact(), PROVENANCE)
    return path


def test_made_once_then_up_to_date_and_never_replaced_unasked(fused):
    page = fused.with_suffix(".html")
    assert report.run(fused, page, Report(), Run(dry_run=True)) is Outcome.WOULD_RUN
    assert not page.exists()
    assert report.run(fused, page, Report(), Run()) is Outcome.DONE
    first = page.read_bytes()
    assert report.run(fused, page, Report(), Run()) is Outcome.UP_TO_DATE
    with pytest.raises(OutputExists, match="--overwrite"):
        report.run(fused, page, Report(width=40), Run())
    assert report.run(fused, page, Report(width=40), Run(overwrite=True)) is Outcome.DONE
    assert page.read_bytes() != first
    assert report.run(fused, page, Report(), Run(overwrite=True)) is Outcome.DONE
    assert page.read_bytes() == first


def test_a_page_that_ipcli_report_did_not_write_there_is_kept_whatever_the_options(fused):
    page = fused.with_suffix(".html")
    report.run(fused, page, Report(), Run())
    whole = page.read_bytes()
    elsewhere = page.with_name("other.html")
    for path, content in ((page, b"notes of my own"), (page, whole[:-1]), (page, whole + b"x"), (elsewhere, whole)):
        path.write_bytes(content)
        for overwrite in (False, True):
            with pytest.raises(OutputRefused, match="not a page that ipcli report wrote there"):
                report.run(fused, path, Report(width=40), Run(overwrite=overwrite))
        assert path.read_bytes() == content


def test_the_page_that_a_command_left_beside_its_artefact_is_up_to_date(fused):
    page, turned = fused.with_suffix(".html"), fused.with_suffix(".turn.html")
    turned.write_text("what can be turned")
    page.write_text(with_turning_page(report.render(fused, Report()), turned.name))
    assert f'href="{turned.name}"' in page.read_text()
    assert report.run(fused, page, Report(), Run()) is Outcome.UP_TO_DATE


def test_the_file_gives_the_page_of_its_arrays(fused):
    from ipcli.report.fusion import fused_depth

    assert report.render(fused, Report(width=40)) == fused_depth.page(fused_artefact(), PROVENANCE, widest=40)


def test_views_have_a_page_too(tmp_path):
    path = write(tmp_path / "sequence.views.h5", scene(k=3))
    assert "Contact sheet" in report.render(path, Report())


def test_an_artefact_is_never_replaced_by_its_page(fused):
    with pytest.raises(ParameterError, match="a page is written as X.html"):
        report.run(fused, fused, Report(), Run(overwrite=True))


def test_a_file_that_is_no_artefact_is_refused(tmp_path):
    stray = tmp_path / "notes.h5"
    stray.write_text("no artefact")
    with pytest.raises(FormatError, match="notes.h5"):
        report.run(stray, tmp_path / "page.html", Report(), Run())
    assert list(tmp_path.iterdir()) == [stray]


def test_the_command_prints_where_the_page_is(fused):
    result = CliRunner().invoke(main, [str(fused), "--json", "--width", "100"], catch_exceptions=False)
    assert result.exit_code == 0
    assert json.loads(result.stdout) == {"output": str(fused.with_suffix(".html")), "outcome": "done"}
