"""brdf-train from the shell: the list that ships, the same bytes twice."""

from pathlib import Path

from ipcli.cli.main import main
from ipcli.io.files import h5
from tests.fixtures.brdf_scenes import LIST, QUICK, library


def test_the_list_that_ships_needs_no_other_file(tmp_path: Path, capsys):
    a, b = library(tmp_path / "a.h5"), tmp_path / "b.h5"
    assert main(["brdf-train", str(LIST), *QUICK, "-o", str(b), "--quiet"]) == 0
    assert a.read_bytes() == b.read_bytes()
    *_, output, materials, lights, maps, scenes, right = capsys.readouterr().out.splitlines()
    found = h5.read(b, "brdf-library").arrays
    assert (output, materials) == (str(b), f"materials: {len(found['materials'])}")
    assert lights == f"lights: {len(found['probes'])}"
    assert (maps, scenes) == (f"maps: {len(found['charts'])}", f"scenes of the judge: {QUICK[3]}")
    assert right.startswith(f"told right: rim {found['rim_accuracy']:.0%}, material ")
    assert "told right" in b.with_suffix(".html").read_text(encoding="utf-8")


def test_a_probe_that_is_none_fails_in_one_line(tmp_path: Path, capsys):
    (tmp_path / "p.hdr").write_bytes(b"#?RADIANCE\n")
    path = tmp_path / "m.toml"
    path.write_text(LIST.read_text(encoding="utf-8") + '[probes]\nfiles = ["p.hdr"]\n')
    assert main(["brdf-train", str(path), *QUICK, "-o", str(tmp_path / "x.h5")]) == 1
    assert "p.hdr" in capsys.readouterr().err
