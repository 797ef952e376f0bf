from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.files import colmap as files
from ipcli.io.files import images
from ipcli.io.views.colmap import open_colmap, read_depth_map

NAMES = ("a.png", "left/b.png", "left/c.png")


def dense(depth: np.ndarray) -> bytes:
    """COLMAP's format of a depth map, 0 where there is none."""
    height, width = depth.shape
    return f"{width}&{height}&1&".encode() + np.nan_to_num(depth, nan=0.0).astype("<f4").tobytes()


def write_model(folder: Path, views, model: str = "PINHOLE", names=NAMES) -> None:
    import pycolmap

    reconstruction = pycolmap.Reconstruction()
    for number, (name, view) in enumerate(zip(names, views, strict=True), start=1):
        camera = pycolmap.Camera.create_from_model_name(number, model, 50.0, 32, 24)
        if model == "PINHOLE":
            camera.params = [
                view.intrinsics[0, 0],
                view.intrinsics[1, 1],
                view.intrinsics[0, 2] + 0.5,
                view.intrinsics[1, 2] + 0.5,
            ]
        reconstruction.add_camera_with_trivial_rig(camera)
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(view.cam_from_world[:3, :3]), view.cam_from_world[:3, 3])
        reconstruction.add_image_with_trivial_frame(pycolmap.Image(name=name, camera_id=number, image_id=number), pose)
    (folder / "sparse").mkdir(parents=True, exist_ok=True)
    reconstruction.write(str(folder / "sparse"))


@pytest.fixture
def workspace(tmp_path, views) -> Path:
    write_model(tmp_path, views)
    for name, view in zip(NAMES, views, strict=True):
        images.write_png(tmp_path / "images" / name, view.image)
        for kind, factor in (("geometric", 1), ("photometric", 2)):
            path = tmp_path / "stereo" / "depth_maps" / f"{name}.{kind}.bin"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(dense(factor * view.depth))
    return tmp_path


def test_a_dense_workspace_is_read_with_pixel_centres_at_integers(workspace, views, same):
    sequence = open_colmap(workspace)
    assert (sequence.names, sequence.unit) == (("a.png", "left_b.png", "left_c.png"), "colmap unit")
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)
    assert workspace / "sparse" / "cameras.bin" in sequence.files("a.png")


def test_photometric_maps_are_taken_when_asked_for_or_when_alone(workspace, views):
    twice = open_colmap(workspace, depth="photometric").load("a.png").depth
    np.testing.assert_array_equal(twice, 2 * views[0].depth)
    for path in workspace.rglob("*.geometric.bin"):
        path.unlink()
    np.testing.assert_array_equal(open_colmap(workspace).load("a.png").depth, twice)


def test_a_reduced_depth_map_projects_to_the_same_places(workspace, views):
    reduced = workspace / "stereo" / "depth_maps" / "a.png.geometric.bin"
    reduced.write_bytes(dense(np.full((12, 16), 2.0)))
    view = open_colmap(workspace).load("a.png")
    assert view.image.shape == (12, 16, 3)
    corner = np.array([-0.5, -0.5, 1.0])  # of the image: the only place that is at the same coordinates in both
    opposite, full = np.array([15.5, 11.5, 1.0]), np.array([31.5, 23.5, 1.0])
    np.testing.assert_allclose(np.linalg.solve(view.intrinsics, corner), np.linalg.solve(views[0].intrinsics, corner))
    np.testing.assert_allclose(np.linalg.solve(view.intrinsics, opposite), np.linalg.solve(views[0].intrinsics, full))


def test_images_without_depth_map_are_left_out(workspace):
    (workspace / "stereo" / "depth_maps" / "left" / "b.png.geometric.bin").unlink()
    assert open_colmap(workspace).names == ("a.png", "left_c.png")


def test_a_workspace_without_depth_maps_says_what_to_run(workspace):
    for path in workspace.rglob("*.bin"):
        if "stereo" in path.parts:
            path.unlink()
    with pytest.raises(
        FormatError, match=r"depth_maps: no depth maps \(expected \*\.geometric\.bin or .*colmap patch_match_stereo"
    ):
        open_colmap(workspace)
    with pytest.raises(FormatError, match="depth_maps: no photometric depth map of a registered image"):
        open_colmap(workspace, depth="photometric")


def test_a_model_with_distortion_or_none_at_all_is_refused(workspace, views):
    write_model(workspace, views, "OPENCV")
    with pytest.raises(
        FormatError,
        match=r"sparse: camera of 'a\.png' has lens distortion \(expected PINHOLE, got OPENCV\).*image_undistorter",
    ):
        open_colmap(workspace)
    (workspace / "sparse" / "images.bin").write_bytes(b"cut")
    with pytest.raises(FormatError, match=r"images\.bin: cut or empty"):
        open_colmap(workspace)


@pytest.mark.parametrize("stem", ["images", "cameras", "points3D", "frames", "rigs"])
@pytest.mark.parametrize("content", [b"", b"\xff" * 8, (1000).to_bytes(8, "little") + bytes(100)])
def test_counts_that_a_file_cannot_hold_are_refused_before_the_native_parser(workspace, stem, content):
    (workspace / "sparse" / f"{stem}.bin").write_bytes(content)
    with pytest.raises(FormatError, match=rf"{stem}\.bin: cut or empty"):
        open_colmap(workspace)


@pytest.mark.parametrize("stem", ["images", "frames"])
def test_a_file_cut_inside_an_item_is_refused_before_the_native_parser(workspace, stem):
    path = workspace / "sparse" / f"{stem}.bin"
    path.write_bytes(path.read_bytes()[:-5])
    with pytest.raises(FormatError, match=rf"{stem}\.bin: cut or empty"):
        open_colmap(workspace)


def test_a_parser_that_does_not_end_is_stopped(workspace, monkeypatch):
    monkeypatch.setattr(files, "check_counts", lambda folder, fix: None)
    monkeypatch.setattr(files, "SECONDS", 1.0)
    path = workspace / "sparse" / "frames.bin"
    path.write_bytes(path.read_bytes()[:72] + b"\xff" * 4 + path.read_bytes()[76:])
    with pytest.raises(FormatError, match=r"sparse: model cannot be read: its parser (took longer|asked for more)"):
        open_colmap(workspace)


def test_images_and_maps_that_are_left_out_are_counted(workspace, views):
    maps = workspace / "stereo" / "depth_maps"
    (maps / "left" / "b.png.geometric.bin").unlink()
    (maps / "other.png.geometric.bin").write_bytes(dense(views[0].depth))
    assert open_colmap(workspace).notes == (
        "1 of 3 registered images left out: no geometric depth map",
        "1 geometric depth maps left out: their image is not registered in sparse/",
    )


def test_the_one_numbered_model_is_taken_and_several_are_refused(workspace, views, same):
    sparse = workspace / "sparse"
    (sparse / "0").mkdir()
    for path in [path for path in sparse.iterdir() if path.is_file()]:
        path.rename(sparse / "0" / path.name)
    same(open_colmap(workspace).load("a.png"), views[0])
    (sparse / "1").mkdir()
    (sparse / "1" / "cameras.bin").write_bytes(bytes(8))
    with pytest.raises(FormatError, match="2 models: 0, 1"):
        open_colmap(workspace)


def test_names_that_differ_in_a_slash_alone_are_refused(workspace, views):
    write_model(workspace, views, names=("left/b.png", "left_b.png", "c.png"))
    (workspace / "stereo" / "depth_maps" / "left_b.png.geometric.bin").write_bytes(dense(views[0].depth))
    with pytest.raises(FormatError, match="two images would be named 'left_b.png'"):
        open_colmap(workspace)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a COLMAP depth map"),
        (b"\x00" * 100, "not a COLMAP depth map"),
        (b"4&3&3&" + bytes(144), "not a COLMAP depth map"),
        (b"4&3&1&" + bytes(47), r"cut or too long \(expected 48 bytes of data, got 47\)"),
        (b"4&3&1&" + bytes(49), "cut or too long"),
    ],
)
def test_depth_maps_that_are_none_are_refused(tmp_path, content, message):
    path = tmp_path / "x.geometric.bin"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=f"x.geometric.bin: .*{message}"):
        read_depth_map(path)


def test_zero_and_negative_values_of_a_depth_map_are_missing(tmp_path):
    path = tmp_path / "x.bin"
    path.write_bytes(b"3&1&1&" + np.array([0, -1, 2.5], "<f4").tobytes())
    np.testing.assert_array_equal(read_depth_map(path), [[np.nan, np.nan, 2.5]])
