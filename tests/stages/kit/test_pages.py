"""A page beside an artefact is the page that its kind has, in UTF-8 and nothing else."""

from pathlib import Path

import pytest

from ipcli import report, schema
from ipcli.errors import ParameterError
from ipcli.io.motion import artefact
from ipcli.stages.kit import pages
from tests.fixtures.mocap_clips import every


def test_the_page_is_named_after_its_artefact_and_is_that_of_its_kind(tmp_path):
    arrays = artefact.clips_arrays(every(frames=3, repeats=1), {})
    output = tmp_path / "a.clips.h5"
    ((path, write),) = pages.page(output, "clips").items()
    assert path == tmp_path / "a.clips.html"
    write(tmp_path / "temporary", arrays, {"seed": 1})
    assert (tmp_path / "temporary").read_bytes() == report.renderer("clips")(arrays, {"seed": 1}).encode()
    assert [item.name for item in tmp_path.iterdir()] == ["temporary"]


@pytest.mark.parametrize("kind", [kind for kind in schema.KINDS if not report.has_page(kind)] + ["nothing"])
def test_a_kind_without_a_page_is_refused_with_those_that_have_one(tmp_path, kind):
    (write,) = pages.page(Path("a.h5"), kind).values()
    with pytest.raises(ParameterError, match="there are some for .*fused-depth"):
        write(tmp_path / "a.html", {}, {})
    assert not list(tmp_path.iterdir())
