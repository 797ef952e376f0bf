"""fuse-depth --all and merge-depth, from views to a cloud."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from ipcli import memory, schema
from ipcli.cli.main import main
from ipcli.errors import FormatError, IpcliError, OutputExists, ParameterError
from ipcli.inverse.regularize.parameters import Solver
from ipcli.io.files import h5, ply
from ipcli.models.fusion import footprint
from ipcli.models.fusion.merge import merge
from ipcli.models.fusion.parameters import Fusion, Merge
from ipcli.params import Run
from ipcli.report.fusion.fusion_cloud import page
from ipcli.stages.fusion import fuse_depth, merge_depth
from ipcli.stages.fusion.parameters import FuseDepth, MergeDepth
from ipcli.stages.kit.artefact import Outcome
from tests.fixtures.fusion_scenes import distance, scene, write

NOISE = 0.02


def fuse(folder, name, **facts):
    source = write(folder / f"{name}.views.h5", scene(7, noise=NOISE), **facts)
    each = FuseDepth(every=True, window=5, fusion=Fusion(solver=Solver(iterations=200), rounds=2))
    return list(fuse_depth.run_all(source, folder / name, each, Run()))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return fuse(tmp_path_factory.mktemp("maps"), "scene")


@pytest.fixture(scope="module")
def cloud(files, tmp_path_factory):
    output = tmp_path_factory.mktemp("cloud") / "x.ply"
    assert merge_depth.run(files, output, MergeDepth(), Run()) is Outcome.DONE
    return output


def contents(output):
    return {suffix: output.with_suffix(suffix).read_bytes() for suffix in (".h5", ".ply", ".html")}


def test_the_cloud_lies_on_the_surface(cloud):
    found = h5.read(cloud.with_suffix(".h5"), "fusion-cloud").arrays
    schema.validate(schema.kind("fusion-cloud"), found)
    assert np.median(distance(found["points"].astype(np.float64))) < NOISE / 3
    assert (found["map_confirmed"] > 0.5 * found["map_points"]).all()
    assert found["map_points"].sum() > 20_000
    assert len(found["points"]) > 4800


def test_the_ply_holds_the_same_points_and_names_the_digest(cloud):
    artefact, points = h5.read(cloud.with_suffix(".h5"), "fusion-cloud"), ply.read(cloud)
    np.testing.assert_array_equal(points.vertices, artefact.arrays["points"])
    np.testing.assert_array_equal(points.normals, artefact.arrays["normals"])
    np.testing.assert_array_equal(points.colors, artefact.arrays["colors"])
    for name in ("confidence", "views"):
        np.testing.assert_array_equal(points.extra[name], artefact.arrays[name])
    assert artefact.provenance["digest"] in points.comments[0]
    assert "unit m" in points.comments[0]


def test_a_cloud_without_colours_is_shown_in_clay(cloud):
    artefact = h5.read(cloud.with_suffix(".h5"), "fusion-cloud")
    plain = {name: array for name, array in artefact.arrays.items() if name != "colors"}
    shown = page(plain, artefact.provenance)
    assert "<img" in shown
    assert shown != cloud.with_suffix(".html").read_text()


def test_the_memory_is_told_before_and_fewer_maps_at_hand_give_the_same_cloud(
    files, cloud, tmp_path, monkeypatch, caplog
):
    assert merge_depth.run(files, tmp_path / "x.ply", MergeDepth(), Run(dry_run=True)) is Outcome.WOULD_RUN
    (said,) = [record.getMessage() for record in caplog.records if "maps" in record.getMessage()]
    assert "x.ply: 7 maps, 0.0336 Mpx in all: at most " in said
    monkeypatch.setattr(footprint, "HELD", 10_000)
    monkeypatch.setattr(footprint, "PUBLISHING", 0)
    monkeypatch.setattr(memory, "budget", lambda: 300_000_000 + 4 * 4800 * 10_000 + 2 * 33600 * footprint.POINT)
    caplog.clear()
    merge_depth.run(files, tmp_path / "x.ply", MergeDepth(), Run())
    assert contents(tmp_path / "x.ply") == contents(cloud)
    (said,) = [record.getMessage() for record in caplog.records if "maps" in record.getMessage()]
    assert "with 4 maps at hand in place of 7" in said
    monkeypatch.setattr(memory, "budget", lambda: 310_000_000)
    with pytest.raises(IpcliError, match=r"7 maps of up to 0.0048 Mpx take 5.*--max-memory is 310 MB. Raise it"):
        merge_depth.run(files, tmp_path / "y.ply", MergeDepth(), Run())


def test_views_are_no_maps(tmp_path):
    source = write(tmp_path / "a.views.h5", scene(2))
    with pytest.raises(FormatError, match=r"wrong kind of artefact.*fused-depth.*fuse-depth --all"):
        merge_depth.run([source], tmp_path / "x.ply", MergeDepth(), Run())


def test_the_order_of_the_files_does_not_matter(files, cloud, tmp_path):
    merge_depth.run([*files[3:], *files[:4][::-1]], tmp_path / "x.ply", MergeDepth(), Run())
    assert contents(tmp_path / "x.ply") == contents(cloud)


def test_maps_that_are_read_over_and_over_give_the_same_cloud(files):
    few, all_at_once = merge_depth.MapsOnDemand(files, held=1), [merge_depth.read_map(path) for path in files]
    a, b = (merge(maps, Merge()) for maps in (few, all_at_once))
    np.testing.assert_array_equal(a.points.position, b.points.position)
    np.testing.assert_array_equal(a.counts, b.counts)
    assert few._read.cache_info().misses > 3 * len(files)


def test_a_second_run_is_up_to_date_and_other_parameters_are_refused(files, cloud):
    before = contents(cloud)
    assert merge_depth.run(files, cloud, MergeDepth(), Run()) is Outcome.UP_TO_DATE
    with pytest.raises(OutputExists, match="--overwrite"):
        merge_depth.run(files, cloud, MergeDepth(Merge(agree=3)), Run())
    with pytest.raises(OutputExists, match="--overwrite"):
        merge_depth.run(files[1:], cloud, MergeDepth(), Run())
    cloud.unlink()
    assert merge_depth.run(files, cloud, MergeDepth(), Run()) is Outcome.DONE
    assert contents(cloud) == before


def test_maps_in_different_units_are_refused(files, tmp_path):
    other = fuse(tmp_path, "feet", unit="ft")
    with pytest.raises(
        FormatError, match="another unit than .*expected ft, got m|another unit than .*expected m, got ft"
    ):
        merge_depth.run([*files, *other], tmp_path / "x.ply", MergeDepth(), Run())
    assert not (tmp_path / "x.ply").exists()


def test_a_copy_of_a_map_is_told_on_the_console_in_the_artefact_and_on_the_page(files, tmp_path, caplog):
    copy = tmp_path / "copy.fused.h5"
    shutil.copy(files[0], copy)
    merge_depth.run([*files, copy], tmp_path / "x.h5", MergeDepth(), Run())
    found = h5.read(tmp_path / "x.h5", "fusion-cloud").arrays["warnings"].tolist()
    assert found == [record.getMessage() for record in caplog.records if "one and the same camera" in record.message]
    assert len(found) == 1
    assert found[0] in (tmp_path / "x.html").read_text()
    assert merge_depth.summary(tmp_path / "x.h5")["warnings"].value == found


def test_another_suffix_is_refused(files, tmp_path):
    with pytest.raises(ParameterError, match="X.ply"):
        merge_depth.run(files, tmp_path / "x.pcd", MergeDepth(), Run())


def test_the_command_line(files, tmp_path, capsys):
    given, output = [*map(str, files)], str(tmp_path / "x.ply")
    assert main(["merge-depth", *given[:2], "-o", output]) == 3
    assert "lower --agree" in capsys.readouterr().err
    assert main(["merge-depth", *given, "-o", output, "--spacing", "0.05"]) == 0
    path, *figures = capsys.readouterr().out.splitlines()
    assert path == output
    assert [figure.split(":")[0] for figure in figures] == ["points", "spacing", "confirmed", "maps a point"]
    assert main(["report", str(tmp_path / "x.h5"), "-o", str(tmp_path / "again.html")]) == 0
    page = (tmp_path / "again.html").read_text(encoding="utf-8")
    assert page.startswith((tmp_path / "x.html").read_text(encoding="utf-8"))  # and its seal
    assert "00.fused.h5" in page
