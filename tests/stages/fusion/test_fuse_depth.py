"""fuse-depth from a views artefact to its three files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import FormatError, NoSolution, OutputExists, ParameterError
from ipcli.geometry.cameras import back_project, transform
from ipcli.inverse.regularize.parameters import Solver
from ipcli.io.files import h5, ply
from ipcli.models.fusion import fuse as model
from ipcli.models.fusion import tiles
from ipcli.models.fusion.assessment import THUMBNAIL, view_table
from ipcli.models.fusion.parameters import Fusion
from ipcli.params import Run
from ipcli.stages.fusion import fuse_depth
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.kit.artefact import Outcome
from tests.fixtures.fusion_scenes import damage, pose_at, scaled, scene, write

QUICK = Fusion(solver=Solver(iterations=200), rounds=2)
FILES = (".h5", ".ply", ".html")


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return write(tmp_path_factory.mktemp("views") / "scene.views.h5", scene(), baseline_focal=20.0)


def fuse(source, folder, run=Run(), **params):
    """The outcome and the path of the artefact."""
    output = folder / "scene.fused.h5"
    return fuse_depth.run(source, output, FuseDepth(**{"fusion": QUICK} | params), run), output


def arrays(source, folder, **params):
    return h5.read(fuse(source, folder, **params)[1], "fused-depth").arrays


def contents(output):
    return {suffix: output.with_suffix(suffix).read_bytes() for suffix in FILES}


@pytest.fixture(scope="module")
def whole(source, tmp_path_factory):
    outcome, output = fuse(source, tmp_path_factory.mktemp("whole"))
    assert outcome is Outcome.DONE
    return output


def test_the_artefact_is_sound_and_better_than_the_median_and_a_mesh_and_a_page_stand_beside_it(whole):
    found = h5.read(whole, "fused-depth").arrays
    schema.validate(schema.kind("fused-depth"), found)
    metrics = dict(zip(map(str, found["metric_rows"]), found["metrics"], strict=True))
    mae = list(map(str, found["metric_columns"])).index("MAE")
    assert metrics["fused"][mae] < 0.8 * metrics["median"][mae] < metrics["reference"][mae]
    assert str(found["method"]) == "l1-adapt (acs)"
    assert str(found["unit"]) == "m"
    assert str(found["domain"]) == "depth"
    page = whole.with_suffix(".html").read_text(encoding="utf-8")
    for heading in ("Maps", "Surface", "Detail", "Metrics", "Against the truth", "Views", "Solver", "Origin"):
        assert f">{heading}</h2>" in page
    assert "5 views by l1-adapt (acs) on depth" in page
    assert all(f">{name}<" in page for name in found["views"])
    assert str(h5.peek(whole).provenance["digest"]) in page
    assert 'src="http' not in page


def test_the_mesh_is_the_supported_part_of_the_map_in_world_coordinates(whole):
    found, mesh = h5.read(whole, "fused-depth").arrays, ply.read(whole.with_suffix(".ply"))
    seen = found["filled"] == 0
    assert not (found["observations"][seen] == 0).any()
    assert len(mesh.vertices) == seen.sum()
    assert mesh.faces.max() < len(mesh.vertices)
    in_camera = transform(found["cam_from_world"], mesh.vertices)
    np.testing.assert_allclose(in_camera, back_project(found["depth"], found["intrinsics"])[seen], atol=1e-5)
    np.testing.assert_array_equal(mesh.extra["confidence"], found["confidence"][seen])
    np.testing.assert_array_equal(mesh.extra["observations"], found["observations"][seen])
    np.testing.assert_array_equal(mesh.colors, found["image"][seen])
    corners = in_camera[mesh.faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", outward, corners[:, 0]) < 0).all()
    facing = np.einsum("ij,ij->i", mesh.normals @ found["cam_from_world"][:3, :3].T, in_camera)
    assert (facing <= 0).all()


def test_the_table_of_views_tells_what_each_gave(whole):
    found = h5.read(whole, "fused-depth").arrays
    assert list(found["views"]) == ["00", "01", "02", "03", "04"]
    truth_free = [view.depth for view in scene()]
    np.testing.assert_allclose(found["view_valid"], [np.isfinite(d).mean() for d in truth_free])
    assert found["view_overlap"][2] == found["view_valid"][2]  # the reference sees itself
    assert (found["view_overlap"] > 0.5).all()
    assert (found["view_residual"] < 0.03).all()
    residual = np.nanmedian(np.abs(truth_free[2] - found["depth"]))
    assert found["view_residual"][2] == pytest.approx(residual, rel=1e-5)
    assert found["noise_scale"] == pytest.approx(0.02, rel=0.2)
    assert found["thumbnails"].shape[0] == 5
    assert max(found["thumbnails"].shape[1:]) <= THUMBNAIL


def test_a_second_run_is_up_to_date_and_other_parameters_are_refused(source, whole):
    before = {path: path.stat().st_mtime_ns for path in whole.parent.iterdir()}
    assert fuse(source, whole.parent)[0] is Outcome.UP_TO_DATE
    with pytest.raises(OutputExists, match="--overwrite"):
        fuse(source, whole.parent, reference="01")
    assert {path: path.stat().st_mtime_ns for path in whole.parent.iterdir()} == before


def test_a_lost_side_file_is_made_again_with_the_same_bytes(source, tmp_path):
    _, output = fuse(source, tmp_path)
    first = contents(output)
    output.with_suffix(".ply").unlink()
    assert fuse(source, tmp_path)[0] is Outcome.DONE
    assert contents(output) == first


@pytest.mark.parametrize("threads", ["1", "2", "3"])
def test_overwriting_gives_the_same_bytes_on_any_number_of_threads(source, whole, tmp_path, monkeypatch, threads):
    monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
    for _ in range(2):
        _, output = fuse(source, tmp_path, Run(overwrite=True, threads=int(threads)))
        assert contents(output) == contents(whole)


def test_a_dry_run_writes_nothing(source, tmp_path):
    assert fuse(source, tmp_path, Run(dry_run=True))[0] is Outcome.WOULD_RUN
    assert not list(tmp_path.iterdir())


WINDOWS = [("02", 3, "123"), ("00", 3, "012"), ("04", 2, "34"), ("01", 1, "1"), (None, 0, "01234")]


@pytest.mark.parametrize(("reference", "window", "names"), WINDOWS)
def test_a_window_takes_the_neighbours_of_the_reference(source, tmp_path, reference, window, names):
    found = arrays(source, tmp_path, reference=reference, window=window)
    assert list(found["views"]) == [f"0{name}" for name in names]
    np.testing.assert_array_equal(found["cam_from_world"], scene()[int(reference or "2")].cam_from_world)


def test_the_domain_is_the_one_with_even_noise_unless_chosen(tmp_path):
    """Noise of disparities is told in pixels."""
    views = scene()
    disparities = write(tmp_path / "d.views.h5", views, measured="disparity", baseline_focal=20.0)
    chosen = {
        domain: arrays(disparities, tmp_path / domain, domain=domain) for domain in ("auto", "depth", "disparity")
    }
    assert [str(found["domain"]) for found in chosen.values()] == ["disparity", "depth", "disparity"]
    np.testing.assert_array_equal(chosen["auto"]["depth"], chosen["disparity"]["depth"])
    assert not np.array_equal(chosen["depth"]["depth"], chosen["auto"]["depth"])
    typical = np.median([view.truth for view in views])
    assert chosen["auto"]["noise_scale"] == pytest.approx(20.0 * 0.02 / typical**2, rel=0.25)


def test_one_view_alone_is_fused(tmp_path):
    found = arrays(
        write(tmp_path / "one.views.h5", scene()[2:3]), tmp_path, fusion=replace(QUICK, method="tgv-l1", lam=1.0)
    )
    assert list(found["views"]) == ["02"]
    assert np.isfinite(found["depth"]).all()
    assert found["metrics"][3, 2] < 0.5 * found["metrics"][0, 2]


def test_views_without_truth_or_colour_make_all_files(tmp_path):
    bare = write(tmp_path / "bare.views.h5", [replace(view, truth=None, image=None) for view in scene()])
    _, output = fuse(bare, tmp_path)
    assert "metrics" not in h5.read(output, "fused-depth").arrays
    assert ply.read(output.with_suffix(".ply")).colors is None


def test_millimetres_give_a_thousand_times_the_depth(source, whole, tmp_path):
    found = h5.read(whole, "fused-depth").arrays
    large = write(tmp_path / "mm.views.h5", [scaled(view, 1000) for view in scene()], unit="mm", baseline_focal=20000.0)
    scaled_map = arrays(large, tmp_path)
    apart = np.abs(scaled_map["depth"] / 1000 - found["depth"])
    assert np.median(apart) < 1e-5
    assert np.quantile(apart, 0.99) < 2e-3
    np.testing.assert_allclose(scaled_map["metrics"][:, 2], 1000 * found["metrics"][:, 2], rtol=1e-2)


def test_views_that_do_not_meet_the_reference_have_no_solution_and_leave_nothing(tmp_path):
    away = [replace(view, cam_from_world=pose_at((50.0 * i, 0, 0))) for i, view in enumerate(scene())]
    with pytest.raises(NoSolution) as caught:
        fuse(write(tmp_path / "away.views.h5", away), tmp_path / "out")
    for view in away:
        assert f"{view.name}: {100 * np.isfinite(view.depth).mean():.0f} % valid, reaches" in str(caught.value)
    assert str(caught.value).count("reaches 0.0 %") == 4
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("field", "values", "message"),
    [
        ("cam_from_world", np.diag([2.0, 2, 2, 1]), "a rigid pose"),
        ("cam_from_world", np.diag([-1.0, 1, 1, 1]), "a rigid pose"),
        ("cam_from_world", np.full((4, 4), np.nan), "a rigid pose"),
        ("intrinsics", np.diag([-50.0, 50, 1]), "fx, fy > 0"),
    ],
)
def test_unsound_views_are_named(tmp_path, field, values, message):
    path = damage(write(tmp_path / "bad.views.h5", scene()), f"views/01/{field}", values)
    with pytest.raises(FormatError, match=f"bad.views.h5.*views/01/{field}.*{message}"):
        fuse(path, tmp_path)


def test_a_reference_that_is_not_there_is_told_with_the_nearest(source, tmp_path):
    with pytest.raises(ParameterError, match="no view '2' among the 5 there are; did you mean '02'"):
        fuse(source, tmp_path, reference="2")


def test_progress_never_goes_back(source, tmp_path):
    told = []
    fuse_depth.run(
        source, tmp_path / "x.h5", FuseDepth(fusion=QUICK), Run(), lambda share, text: told.append((share, text))
    )
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[0] >= 0
    assert shares[-1] <= 1
    assert len({text for _, text in told}) >= 3


def test_in_tiles_the_artefact_is_sound_and_as_near_to_the_truth(whole, source, tmp_path):
    tiled, at_once = arrays(source, tmp_path, fusion=replace(QUICK, tile=32)), h5.read(whole, "fused-depth").arrays
    schema.validate(schema.kind("fused-depth"), tiled)
    np.testing.assert_allclose(tiled["metrics"], at_once["metrics"], rtol=0.05, atol=1e-3)
    np.testing.assert_allclose(tiled["view_overlap"], at_once["view_overlap"], atol=0.05)
    views, every = scene(), tiles.EVERY
    alone = model.fuse(views, views[2], QUICK, inverse=False)
    thinned = replace(alone, layers=alone.layers[:, ::every, ::every], every=every)
    same_pixels = view_table(thinned, [view.name for view in views], views)
    np.testing.assert_allclose(tiled["view_residual"], same_pixels["view_residual"], rtol=0.05)
    np.testing.assert_array_equal(tiled["view_valid"], at_once["view_valid"])


def test_a_likely_mistake_and_a_fusion_that_did_not_converge_are_said_in_the_artefact_and_on_the_page(tmp_path, caplog):
    views = [replace(view, cam_from_world=np.linalg.inv(view.cam_from_world)) for view in scene()]
    source = write(tmp_path / "wrong.views.h5", views, baseline_focal=20.0)
    short = Fusion(solver=Solver(iterations=1, levels=1, tolerance=1e-7), rounds=1, reassociate=0)
    output = fuse(source, tmp_path, fusion=short)[1]
    warnings = " ".join(h5.read(output, "fused-depth").arrays["warnings"].tolist())
    assert "did not converge" in warnings
    assert "--pose" in warnings
    for text in (output.with_suffix(".html").read_text(), caplog.text):
        assert "did not converge" in text
        assert "in the other direction" in text


def test_sound_views_are_not_warned_of(whole):
    assert "warnings" not in h5.read(whole, "fused-depth").arrays


@pytest.mark.parametrize("tile", [0, 32])
def test_geometry_is_checked_in_tiles_too(tmp_path, caplog, tile):
    views = [replace(view, cam_from_world=np.linalg.inv(view.cam_from_world)) for view in turned_scene()]
    source = write(tmp_path / "turned.views.h5", views)
    found = arrays(source, tmp_path, fusion=replace(QUICK, tile=tile))
    assert any("in the other direction: see --pose" in warning for warning in found["warnings"].tolist())
    assert any("in the other direction: see --pose" in record.getMessage() for record in caplog.records)


def turned_scene():
    """Views on an arc, whose poses are told from their inverses."""
    return scene(5, noise=0.002, holes=0.0)
