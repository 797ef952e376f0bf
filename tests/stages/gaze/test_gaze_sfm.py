"""The gaze commands on a small generated folder: what they write, and that other programs read it."""

import json

import numpy as np
import pytest

from experiments.gaze import room
from ipcli.cli.main import main
from ipcli.errors import ParameterError
from ipcli.geometry import lens
from ipcli.io.files import h5, ply
from ipcli.io.gaze import layouts
from ipcli.params import Run
from ipcli.stages.gaze import gaze_sfm
from ipcli.stages.gaze.parameters import GazeSfm, RecordingSource
from ipcli.stages.gaze.sources import open_source
from tests.fixtures.attack.seeds import SEEDS

COURSE = room.Course(frames=8, width=320, height=240, gaze_rate=45.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("room")
    room.write_euroc(room.walk(COURSE, 2), place)
    return place


@pytest.fixture(scope="module")
def made(folder, tmp_path_factory):
    output = tmp_path_factory.mktemp("out") / "run.h5"
    assert main(["gaze-sfm", str(folder), "-o", str(output), "--gaze-sigma", "0.71"]) == 0
    return output


def test_the_artefact_holds_the_experiment_and_its_accuracy(made):
    a = h5.read(made, "gaze-experiment").arrays
    assert not a["lost"].any()
    assert a["accuracy/path"][0] < 0.01
    assert (a["por/outcome"] == "hit").mean() > 0.8
    assert a["accuracy/regards"].sum() == (a["por/outcome"] == "hit").sum()


@pytest.mark.parametrize("end", ["txt", "bin"])
def test_pycolmap_opens_the_model_and_its_points_project_where_they_were_seen(made, tmp_path, end):
    pycolmap = pytest.importorskip("pycolmap")
    for name in ("cameras", "images", "points3D"):
        (tmp_path / f"{name}.{end}").write_bytes(made.with_suffix(f".{name}.{end}").read_bytes())
    model = pycolmap.Reconstruction(str(tmp_path))
    assert len(model.images) == 2 * COURSE.frames
    assert model.images[1].name.startswith("left/")
    model.update_point_3d_errors()
    errors = np.array([point.error for point in model.points3D.values()])
    assert len(errors) == len(h5.read(made, "gaze-experiment").arrays["map/points"])
    assert np.median(errors) < 1.0  # pixels


@pytest.mark.parametrize("cameras", [1, 2])
def test_another_recording_is_localised_in_the_colmap_model_as_in_the_run(made, folder, tmp_path, capsys, cameras):
    for name in ("cameras", "images", "points3D"):
        (tmp_path / f"{name}.bin").write_bytes(made.with_suffix(f".{name}.bin").read_bytes())
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "left").symlink_to(folder / "cam0")
    other = tmp_path / "other"
    room.write_euroc(room.walk(COURSE, 3), other)
    for place in (other / "cam1", other / "cam1_sensor.yaml") if cameras == 1 else ():
        place.rename(other / f"no_{place.name}")
    words = ["gaze-sfm", str(other), "--quiet", "--poses-only", "-o"]
    images = ["--map-images", str(tmp_path / "pictures")]
    assert main([*words, str(tmp_path / "a.h5"), "--map", str(tmp_path), *images]) == 0
    assert main([*words, str(tmp_path / "b.h5"), "--map", str(made)]) == 0
    a, b = (h5.read(tmp_path / f"{name}.h5", "gaze-experiment").arrays for name in "ab")
    both = (a["lost"] == 0) & (b["lost"] == 0)
    assert both.mean() > 0.6
    assert np.linalg.norm((a["world_from_rig"] - b["world_from_rig"])[both, :3, 3], axis=1).max() < 0.03
    assert main([*words, str(tmp_path / "c.h5"), "--map", str(tmp_path)]) == 2
    assert "--map-images" in capsys.readouterr().err


def test_the_csv_has_a_line_a_sample_and_the_cloud_all_its_parts(made):
    a = h5.read(made, "gaze-experiment").arrays
    lines = made.with_suffix(".por.csv").read_text().splitlines()
    assert len(lines) == 1 + len(a["gaze/times"])
    hit = int(np.flatnonzero(a["por/outcome"] == "hit")[0])
    cells = lines[1 + hit].split(",")
    assert np.allclose([float(cell) for cell in cells[2:5]], a["por/points"][hit], atol=1e-4)
    cloud = ply.read(made.with_suffix(".ply"))
    assert set(np.unique(cloud.extra["part"])) == {0, 1, 2, 3}


def test_the_page_says_what_there_is_and_loads_nothing(made):
    html = made.with_suffix(".html").read_text()
    for words in ("Path and map", "Panorama", "Coherent subsequences", "Accuracy", "truth in 68 % region"):
        assert words in html
    assert "<script" not in html
    assert "http" not in html.replace("http://www.w3.org", "")
    assert made.with_suffix(".turn.html").stat().st_size > 1e5


def test_without_gaze_nothing_speaks_of_what_was_looked_at(folder, tmp_path, capsys):
    run = tmp_path / "run.h5"
    assert main(["gaze-sfm", str(folder), "-o", str(run), "--poses-only", "--stop", "3"]) == 0
    out = capsys.readouterr().out
    assert "points of regard: none" in out
    assert "path length [m]: " in out
    html = run.with_suffix(".html").read_text()
    for words in ("What was looked at", "what they looked at", "points of regard (red)", "all points of regard"):
        assert words not in html
    assert "away from its start" in html
    assert "regard" not in run.with_suffix(".turn.html").read_text()


def test_a_second_run_is_up_to_date(made, folder, capsys):
    before = made.stat().st_mtime_ns
    assert main(["gaze-sfm", str(folder), "-o", str(made), "--gaze-sigma", "0.71"]) == 0
    assert "up to date" in capsys.readouterr().err
    assert made.stat().st_mtime_ns == before


def test_an_imported_recording_gives_the_same_poses(folder, made, tmp_path, capsys):
    one = tmp_path / "one.h5"
    assert main(["import-recording", str(folder), "-o", str(one)]) == 0
    found, given = layouts.open_recording(one), layouts.open_recording(folder)
    assert (found.load(3).right == given.load(3).right).all()
    again = tmp_path / "again.h5"
    assert main(["gaze-sfm", str(one), "-o", str(again), "--gaze-sigma", "0.71", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert facts["frames"] == COURSE.frames
    a, b = (h5.read(path, "gaze-experiment").arrays for path in (made, again))
    assert (a["world_from_rig"] == b["world_from_rig"]).all()


def test_gaze_is_corrected_by_fixation_targets(folder, tmp_path, capsys):
    given = layouts.open_recording(folder)
    assert main(["import-recording", str(folder), "-o", str(tmp_path / "plain.h5"), "--quiet"]) == 0
    gaze = layouts.open_recording(tmp_path / "plain.h5").gaze
    chosen = np.flatnonzero(gaze.valid)[::3]
    lines = [f"{gaze.times[k]:.6f},{gaze.times[k]:.6f},{gaze.pixels[k, 0] + 5},{gaze.pixels[k, 1] - 3}" for k in chosen]
    (tmp_path / "fixed.csv").write_text("time [s],until [s],x [px],y [px]\n" + "\n".join(lines) + "\n")
    words = ["--calibrate-gaze", str(tmp_path / "fixed.csv"), "--quiet"]
    assert main(["import-recording", str(folder), "-o", str(tmp_path / "one.h5"), *words]) == 0
    moved = layouts.open_recording(tmp_path / "one.h5").gaze.pixels - gaze.pixels
    np.testing.assert_allclose(moved[gaze.valid], np.tile([5.0, -3.0], (int(gaze.valid.sum()), 1)), atol=1e-3)
    assert given.gaze is None  # it lies beside the pictures
    rays = tmp_path / "rays.csv"
    rays.write_text("time [s],dx,dy,dz\n1.0,0,0,1\n1.2,0,0,1\n")
    assert main(["gaze-sfm", "check", str(folder), "--gaze", str(rays), *words[:2]]) == 2
    assert "needs gaze in pixels" in capsys.readouterr().err


def test_views_of_the_map_lie_on_the_true_surface(folder, made, tmp_path):
    output = tmp_path / "run.views.h5"
    assert main(["gaze-views", str(folder), str(made), "-o", str(output)]) == 0
    a = h5.read(output, "views").arrays
    depth = next(value for name, value in sorted(a.items()) if name.endswith("/depth"))
    known = np.isfinite(depth)
    assert known.mean() > 0.5
    assert 1.0 < np.median(depth[known]) < 4.5


def test_check_prints_figures_and_warnings(folder, capsys):
    assert main(["gaze-sfm", "check", str(folder), "--pairs", "3"]) == 0
    out = capsys.readouterr().out
    assert "vertical disparity [px]" in out
    assert "gaze inside the picture" in out


def _marks(walked):
    """The targets as a table of landmarks, each marked where the frames show it."""
    recording = walked.recording
    camera = recording.cameras[0]
    lines = ["name,x [m],y [m],z [m],frame,u [px],v [px]"]
    for k, world_from_rig in enumerate(recording.truth):
        seen = (room.TARGETS - world_from_rig[:3, 3]) @ world_from_rig[:3, :3]
        drawn = lens.distort(camera.model, camera.distortion, seen[:, :2] / seen[:, 2:])
        for name, place, z, (u, v) in zip(
            room.NAMES, room.TARGETS, seen[:, 2], lens.pixels_of(drawn, camera.intrinsics), strict=True
        ):
            if z > 0.5 and 0 <= u < camera.size[0] and 0 <= v < camera.size[1]:
                stamp = round(recording.times[k] * 1e9) + 1_000_000_000
                lines.append(",".join([name, *map(str, place), str(stamp), f"{u:.3f}", f"{v:.3f}"]))
    return "\n".join(lines) + "\n"


def test_the_world_of_landmarks_and_the_time_on_areas_of_interest(folder, tmp_path):
    walked = room.walk(COURSE, 2)
    (tmp_path / "world.csv").write_text(_marks(walked))
    cubes = [f'"{n}, the",{",".join(map(str, [*(t - 0.4), *(t + 0.4)]))}' for n, t in enumerate(room.TARGETS)]
    (tmp_path / "aoi.csv").write_text("\n".join(["name,x0 [m],y0 [m],z0 [m],x1 [m],y1 [m],z1 [m]", *cubes]) + "\n")
    run = tmp_path / "run.h5"
    words = ["--world", str(tmp_path / "world.csv"), "--aoi", str(tmp_path / "aoi.csv"), "--gaze-sigma", "0.71"]
    assert main(["gaze-sfm", str(folder), "-o", str(run), *words, "--quiet"]) == 0
    a = h5.read(run, "gaze-experiment").arrays
    off = a["world_from_rig"][:, :3, 3] - walked.recording.truth[:, :3, 3]
    assert np.linalg.norm(off, axis=1).max() < 0.03  # no truth but the landmarks went in
    looked = np.bincount(walked.looked_at, minlength=len(room.TARGETS)) / len(walked.looked_at)
    np.testing.assert_allclose(a["aoi/share"], looked, atol=0.15)
    table = (tmp_path / "run.aoi.csv").read_text().splitlines()
    assert table[0].startswith('area,dwell [s],share,visits,fixations,first look [s],"to 0, the"')
    assert len(table) == 1 + len(room.TARGETS)
    html = run.with_suffix(".html").read_text()
    assert "Areas of interest" in html
    assert "The world is that of these landmarks" in html


def test_areas_without_gaze_are_a_mistake_that_is_told_before_the_work(folder, tmp_path, capsys):
    aoi = tmp_path / "aoi.csv"
    aoi.write_text("name,x0 [m],y0 [m],z0 [m],x1 [m],y1 [m],z1 [m]\na,0,0,0,1,1,1\n")
    assert main(["gaze-sfm", str(folder), "-o", str(tmp_path / "x.h5"), "--poses-only", "--aoi", str(aoi)]) != 0
    assert "--aoi: there is no gaze" in capsys.readouterr().err


def test_a_recording_is_localised_in_the_map_of_an_earlier_run(made, folder, tmp_path):
    run = tmp_path / "again.h5"
    words = ["--map", str(made), "--start", "2", "--stop", "6"]
    assert main(["gaze-sfm", str(folder), "-o", str(run), *words, "--quiet"]) == 0
    a, earlier = h5.read(run, "gaze-experiment").arrays, h5.read(made, "gaze-experiment").arrays
    off = a["world_from_rig"][:, :3, 3] - earlier["world_from_rig"][2:6, :3, 3]
    assert np.linalg.norm(off, axis=1).max() < 0.01
    np.testing.assert_array_equal(a["map/points"], earlier["map/points"])


@pytest.mark.parametrize(("only", "count"), [(False, 1), (True, 0)])
def test_a_recording_without_gaze_is_said_to_have_none(tmp_path, caplog, only, count):
    source = SEEDS["gaze/kitti"].write(tmp_path)
    gaze_sfm.run(source, tmp_path / "x.h5", GazeSfm(poses_only=only), Run(dry_run=True))
    assert sum("no gaze, so no points of regard" in record.message for record in caplog.records) == count


def test_pictures_left_out_are_warned_of_and_an_empty_window_tells_how_many_there_are(tmp_path, caplog):
    room.write_euroc(room.walk(room.Course(frames=3, width=64, height=48, gaze_rate=30.0), 1), tmp_path)
    sorted((tmp_path / "cam1").iterdir())[2].unlink()
    open_source(tmp_path, RecordingSource())
    assert "1 pictures have no partner" in caplog.text
    with pytest.raises(ParameterError, match="none of its 2 frames lies between --start 5 and --stop 2"):
        open_source(tmp_path, RecordingSource(start=5))
