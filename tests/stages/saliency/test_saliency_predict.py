import numpy as np
import pytest

from ipcli.errors import FormatError, IpcliError
from ipcli.io.files import h5, images, ply
from ipcli.params import Run
from ipcli.stages.saliency import saliency_predict
from ipcli.stages.saliency.parameters import SaliencyPredict
from tests.fixtures.fixation_sets import bumpy, picture


def test_a_folder_gives_a_map_for_each_picture(tmp_path):
    for seed in range(2):
        images.write_png(tmp_path / "in" / f"{seed}.png", picture(seed)[0])
    (tmp_path / "in" / "notes.txt").write_text("no picture")
    saliency_predict.run(tmp_path / "in", tmp_path / "x.h5", None, SaliencyPredict(), Run())
    assert {path.name for path in tmp_path.glob("x.*")} == {"x.h5", "x.html", "x.0.png", "x.1.png", "x.run.json"}
    arrays = h5.read(tmp_path / "x.h5", "saliency-maps").arrays
    assert arrays["pictures/1/map"].mean() == pytest.approx(1, rel=1e-4)
    assert saliency_predict.summary(tmp_path / "x.h5")["pictures"] == 2


def test_large_pictures_are_kept_smaller_and_two_of_one_stem_apart(tmp_path):
    canvas = picture(0)[0]
    for name in ("a.png", "a.jpg"):
        images.write_png(tmp_path / name, canvas)
    assert set(saliency_predict.pictures_of(tmp_path)) == {"a.png", "a.jpg"}
    (tmp_path / "a.jpg").unlink()
    saliency_predict.run(tmp_path / "a.png", tmp_path / "x.h5", None, SaliencyPredict(largest=64), Run())
    assert h5.read(tmp_path / "x.h5", "saliency-maps").arrays["pictures/a/picture"].shape == (48, 64, 3)


def test_a_picture_of_one_colour_is_told_to_have_a_flat_map(tmp_path, caplog):
    rng = np.random.default_rng(0)
    images.write_png(tmp_path / "all" / "grey.png", np.full((60, 80, 3), 128, np.uint8))
    images.write_png(tmp_path / "all" / "busy.png", rng.integers(0, 255, (60, 80, 3), np.uint8))
    saliency_predict.run(tmp_path / "all", tmp_path / "a.h5", None, SaliencyPredict(), Run())
    (said,) = [record.getMessage() for record in caplog.records if "nothing stands out" in record.getMessage()]
    assert said.startswith(str(tmp_path / "all" / "grey.png"))


def test_a_mesh_keeps_its_triangles_and_gets_normals(tmp_path):
    import trimesh

    mesh = trimesh.creation.icosphere(3)
    mesh.vertices[0] *= 1.5
    mesh.export(tmp_path / "m.ply")
    saliency_predict.run(tmp_path / "m.ply", tmp_path / "x.h5", None, SaliencyPredict(), Run())
    made = ply.read(tmp_path / "x.m.ply")
    assert made.faces is not None
    assert made.extra["saliency"].argmax() in mesh.vertex_neighbors[0] + [0]


def test_a_surface_whose_z_points_up_is_predicted_on_as_one_whose_y_does(tmp_path):
    points, normals = (part.astype(np.float32) for part in bumpy(0)[:2])
    ply.write(tmp_path / "s.ply", points, normals=normals)
    saliency_predict.run(tmp_path / "s.ply", tmp_path / "y.h5", None, SaliencyPredict(), Run())
    lying = [part[:, [2, 0, 1]] for part in (points, normals)]  # y up -> z up, by a rotation
    (tmp_path / "z").mkdir()
    ply.write(tmp_path / "z" / "s.ply", lying[0], normals=lying[1])
    saliency_predict.run(tmp_path / "z" / "s.ply", tmp_path / "z.h5", None, SaliencyPredict(up="z"), Run())
    a, b = (h5.read(tmp_path / f"{name}.h5", "saliency-maps").arrays for name in "yz")
    for part in ("points", "normals", "map"):
        np.testing.assert_allclose(a[f"surfaces/s/{part}"], b[f"surfaces/s/{part}"], atol=1e-5)
    np.testing.assert_array_equal(ply.read(tmp_path / "z.s.ply").vertices, lying[0])  # the file's own axes
    assert "Bright is likely" in (tmp_path / "z.turn.html").read_text()
    assert "z.turn.html" in (tmp_path / "z.html").read_text()


def test_what_cannot_be_predicted_on_is_refused(tmp_path):
    points = bumpy(0)[0].astype(np.float32)
    ply.write(tmp_path / "cloud.ply", points)
    ply.write(tmp_path / "few.ply", points[:5], normals=points[:5])
    for name, message in (("cloud.ply", "without normals"), ("few.ply", "too few"), ("none", "no such file")):
        with pytest.raises(FormatError, match=message):
            saliency_predict.run(tmp_path / name, tmp_path / "x.h5", None, SaliencyPredict(), Run())
    (tmp_path / "empty").mkdir()
    with pytest.raises(FormatError, match="no picture"):
        saliency_predict.pictures_of(tmp_path / "empty")


@pytest.mark.parametrize("suffix", [".obj", ".stl", ".glb"])
def test_any_mesh_gives_the_map_of_its_ply(tmp_path, suffix):
    import trimesh

    ball = trimesh.creation.icosphere(2)
    found = {}
    for name in (f"a{suffix}", "a.ply"):
        source, output = tmp_path / name, tmp_path / f"{name}.maps.h5"
        ball.export(source)
        saliency_predict.run(source, output, None, SaliencyPredict(), Run())
        arrays = h5.read(output, "saliency-maps").arrays
        found[name] = sorted(
            zip(arrays["surfaces/a/points"].round(4).tolist(), arrays["surfaces/a/map"].tolist(), strict=True)
        )
    points, maps = (np.array([row[part] for row in found[f"a{suffix}"]], float) for part in (0, 1))
    np.testing.assert_allclose(points, np.array([row[0] for row in found["a.ply"]]), atol=2e-4)
    assert np.isfinite(maps).all()
    assert len(maps) == 162


def test_a_broken_picture_does_not_stop_the_others_and_is_named(tmp_path):
    folder, output = tmp_path / "in", tmp_path / "out.h5"
    for name in "ab":
        images.write_png(folder / f"{name}.png", np.full((24, 32, 3), 90, np.uint8))
    (folder / "c.png").write_bytes(b"broken")
    for _ in range(2):  # again: the others are up to date, and it is still named
        with pytest.raises(IpcliError, match=r"1 of 3 pictures left out of .*out\.h5: c: .*c\.png.*Mend or remove"):
            saliency_predict.run(folder, output, None, SaliencyPredict(), Run())
    assert saliency_predict.summary(output)["pictures"] == 2
    assert output.with_suffix(".a.png").is_file()


def test_a_folder_of_surfaces_is_told_that_they_are_given_one_by_one(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(
        FormatError, match=r"no picture and no surface.*\.ply \.obj \.off \.stl \.glb.*one by one: .*a\.obj"
    ):
        saliency_predict.run(tmp_path, tmp_path / "out.h5", None, SaliencyPredict(), Run())
