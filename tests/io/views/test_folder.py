from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import images
from ipcli.io.views.folder import middlebury, open_folder


def row(name: str, matrix: np.ndarray) -> str:
    return " ".join([name, *(f"{value:.12f}" for value in matrix.ravel())])


@pytest.fixture
def plain(tmp_path, views) -> Path:
    """Three views in 16-bit millimetres with camera-to-world poses of 12 numbers and one camera for all."""
    for view in views:
        images.write_depth_png16(tmp_path / "depth" / f"{view.name}.png", view.depth, 1000)
        images.write_png(tmp_path / "image" / f"{view.name}.png", view.image)
    lines = [row(view.name, np.linalg.inv(view.cam_from_world)[:3]) for view in views]
    (tmp_path / "poses.txt").write_text("\n".join(["# world_from_cam", *lines]))
    (tmp_path / "intrinsics.txt").write_text("52 50 15.5 11.5")
    (tmp_path / "views.toml").write_text('unit = "m"\ndepth_scale = 1000\n')
    return tmp_path


def read_all(folder: Path, **hints):
    sequence = open_folder(folder, **hints)
    return [sequence.load(name) for name in sequence.names]


def test_a_plain_folder_is_read_as_it_was_written(plain, views, same):
    sequence = open_folder(plain)
    assert (sequence.names, sequence.unit, sequence.measured) == (("0", "1", "2"), "m", "depth")
    for name, view in zip(sequence.names, views, strict=True):
        same(sequence.load(name), view)
    assert [path.name for path in sequence.files("1")] == [
        "1.png",
        "1.png",
        "intrinsics.txt",
        "poses.txt",
        "views.toml",
    ]


def test_poses_may_be_4x4_and_world_to_camera(plain, views, same):
    (plain / "poses.txt").write_text(
        "\n".join(["# name, cam_from_world", *(row(view.name, view.cam_from_world) for view in views)])
    )
    for found, view in zip(read_all(plain), views, strict=True):
        same(found, view)


def test_the_direction_of_poses_can_come_from_the_manifest_or_a_hint(plain, views, same):
    lines = (plain / "poses.txt").read_text().splitlines()[1:]
    (plain / "poses.txt").write_text("\n".join(lines))
    same(read_all(plain, pose="world_from_cam")[2], views[2])
    with (plain / "views.toml").open("a") as stream:
        stream.write('pose = "world_from_cam"\n')
    same(read_all(plain)[2], views[2])


def test_the_direction_of_poses_is_never_guessed(plain):
    poses = plain / "poses.txt"
    body = "\n".join(poses.read_text().splitlines()[1:])
    poses.write_text(body)
    with pytest.raises(
        FormatError,
        match=r"poses.txt: the direction of the poses is not stated \(expected cam_from_world or world_from_cam\)",
    ):
        open_folder(plain)
    poses.write_text("# world_from_cam\n" + body)
    with pytest.raises(FormatError, match="stated twice, differently"):
        open_folder(plain, pose="cam_from_world")


@pytest.mark.parametrize("dialect", ["commas", "tabs", "mark", "suffix", "folder and suffix", "spaces"])
def test_poses_of_many_dialects_are_read(plain, views, same, dialect):
    poses, names = plain / "poses.txt", [view.name for view in views]
    lines = [row(view.name, view.cam_from_world) for view in views]
    change = {
        "commas": lambda line: line.replace(" ", ","),
        "tabs": lambda line: line.replace(" ", "\t"),
        "mark": lambda line: line,
        "suffix": lambda line: line.replace(" ", ".png ", 1),
        "folder and suffix": lambda line: "depth/" + line.replace(" ", ".png ", 1),
        "spaces": lambda line: "frame 00" + line,
    }[dialect]
    if dialect == "spaces":
        for name in names:
            for part in ("depth", "image"):
                (plain / part / f"{name}.png").rename(plain / part / f"frame 00{name}.png")
    text = "\n".join(["# cam_from_world", *map(change, lines)])
    poses.write_text(text, encoding="utf-8-sig" if dialect == "mark" else "utf-8")
    for found, view in zip(read_all(plain), views, strict=True):
        np.testing.assert_allclose(found.cam_from_world, view.cam_from_world, atol=1e-9)
        np.testing.assert_array_equal(found.depth, read_all(plain)[int(view.name)].depth)


def test_views_come_in_the_order_of_their_numbers(plain, views):
    for old, new in (("0", "9"), ("1", "10"), ("2", "100")):
        (plain / "depth" / f"{old}.png").rename(plain / "depth" / f"{new}.png")
    lines = [row(new, view.cam_from_world) for new, view in zip(("9", "10", "100"), views, strict=True)]
    (plain / "poses.txt").write_text("\n".join(["# cam_from_world", *lines]))
    assert open_folder(plain).names == ("9", "10", "100")


def test_the_distance_along_the_ray_becomes_depth(plain, views):
    (plain / "views.toml").write_text("")
    rows, columns = np.indices(views[0].depth.shape)
    length = np.sqrt(((columns - 15.5) / 52) ** 2 + ((rows - 11.5) / 50) ** 2 + 1)
    for view in views:
        (plain / "depth" / f"{view.name}.png").unlink()
        np.save(plain / "depth" / f"{view.name}.npy", (view.depth * length).astype(np.float32))
    sequence = open_folder(plain, measured="distance")
    assert sequence.measured == "depth"
    np.testing.assert_allclose(sequence.load("1").depth, views[1].depth, rtol=1e-5)


@pytest.mark.parametrize("how", ["calib.txt", "hint"])
def test_disparities_of_cameras_whose_centres_differ_are_shifted(plain, views, how):
    (plain / "views.toml").write_text('measured = "disparity"\nbaseline_focal = 42.0\n')
    if how == "calib.txt":
        (plain / "calib.txt").write_text("cam0=[52 0 15.5; 0 50 11.5; 0 0 1]\ndoffs=12.0\nbaseline=100\n")
    for view in views:
        (plain / "depth" / f"{view.name}.png").unlink()
        np.save(plain / "depth" / f"{view.name}.npy", np.maximum(42.0 / view.depth - 12, 1e-6).astype(np.float32))
    seen = 42.0 / views[0].depth > 12.1
    found = open_folder(plain, **({} if how == "calib.txt" else {"doffs": 12.0})).load("0").depth
    np.testing.assert_allclose(found[seen], views[0].depth[seen], rtol=1e-4)


def test_calib_txt_gives_baseline_times_focal_length_and_says_what_is_none(plain):
    path = plain / "calib.txt"
    path.write_text("cam0=[52 0 15.5; 0 50 11.5; 0 0 1]\ndoffs=12.0\nbaseline=100\n")
    assert middlebury(path) == {"doffs": 12.0, "baseline_focal": 5200.0}
    path.write_text("something else\n")
    with pytest.raises(FormatError, match=r"calib.txt: line 1 is no key=value"):
        middlebury(path)


def test_a_stated_value_means_no_data_and_a_negative_confidence_is_called_so(plain, views):
    for view in views:
        (plain / "depth" / f"{view.name}.png").unlink()
        holed = view.depth.copy()
        holed[:3] = -1
        np.save(plain / "depth" / f"{view.name}.npy", holed)
    (plain / "views.toml").write_text("")
    with pytest.raises(FormatError, match="negative depth.*--missing"):
        open_folder(plain).load("0")
    found = open_folder(plain, missing=-1).load("0").depth
    assert np.isnan(found[:3]).all()
    np.testing.assert_array_equal(found[3:], views[0].depth[3:])
    (plain / "confidence").mkdir()
    np.save(plain / "confidence" / "0.npy", np.full(found.shape, -0.5, np.float32))
    with pytest.raises(FormatError, match=r"confidence/0\.npy: negative confidence"):
        open_folder(plain, missing=-1).load("0")


@pytest.mark.parametrize("rows", [3, 4])
def test_a_camera_matrix_may_stand_in_the_corner_of_a_larger_one(plain, rows):
    matrix = np.eye(4)
    matrix[:3, :3] = [[52, 0, 15.5], [0, 50, 11.5], [0, 0, 1]]
    np.savetxt(plain / "intrinsics.txt", matrix[:rows])
    np.testing.assert_array_equal(read_all(plain)[0].intrinsics, matrix[:3, :3])
    matrix[0, 3] = 7
    np.savetxt(plain / "intrinsics.txt", matrix[:rows])
    with pytest.raises(FormatError, match="outside its 3 x 3 corner"):
        open_folder(plain)


@pytest.mark.parametrize("layout", ["matrix", "row", "a line a view"])
def test_intrinsics_may_be_a_matrix_a_row_or_a_line_a_view(plain, views, same, layout):
    matrix = views[0].intrinsics
    texts = {
        "matrix": "\n".join(" ".join(map(str, line)) for line in matrix),
        "row": " ".join(map(str, matrix.ravel())),
        "a line a view": "# name fx fy cx cy\n" + "\n".join(f"{name} {50 + int(name)} 50 15.5 11.5" for name in "210"),
    }
    (plain / "intrinsics.txt").write_text(texts[layout])
    focal = [view.intrinsics[0, 0] for view in read_all(plain)]
    assert focal == ([50, 51, 52] if layout == "a line a view" else [52, 52, 52])


@pytest.mark.parametrize("suffix", [".pfm", ".npy", ".tiff"])
def test_depth_is_read_from_float_files_of_any_size(plain, views, suffix):
    import cv2

    (plain / "views.toml").unlink()
    small = views[1].depth[:10, :20].copy()
    for name in "012":
        (plain / "depth" / f"{name}.png").unlink()
    path = plain / "depth" / f"1{suffix}"
    if suffix == ".npy":
        np.save(path, np.where(np.isnan(small), 0, small))
    elif suffix == ".pfm":
        path.write_bytes(b"Pf\n20 10\n-1\n" + np.flipud(small).astype("<f4").tobytes())
    else:
        cv2.imwrite(str(path), small)
    (plain / "image" / "1.png").unlink()
    (view,) = read_all(plain)
    np.testing.assert_array_equal(view.depth, small)


def test_confidence_and_truth_come_along_by_stem(plain, views):
    confidence = np.linspace(0, 1, views[0].depth.size, dtype=np.float32).reshape(views[0].depth.shape)
    (plain / "confidence").mkdir()
    np.save(plain / "confidence" / "0.npy", confidence)
    images.write_png(plain / "confidence" / "1.png", np.rint(255 * confidence).astype(np.uint8))
    images.write_depth_png16(plain / "truth" / "2.png", views[2].depth, 1000)
    first, second, third = read_all(plain)
    np.testing.assert_allclose(first.confidence, confidence)
    np.testing.assert_allclose(second.confidence, confidence, atol=0.5 / 255)
    np.testing.assert_array_equal(third.truth, views[2].depth)
    assert first.truth is None
    assert third.confidence is None


def test_disparities_become_depth_by_baseline_and_focal_length(plain, views):
    for view in views:
        images.write_depth_png16(plain / "depth" / f"{view.name}.png", 60 / view.depth, 256)
    found = read_all(plain, measured="disparity", baseline_focal=60.0, depth_scale=256)[0].depth
    step = views[0].depth ** 2 / 60 / 256
    known = np.isfinite(views[0].depth)
    np.testing.assert_array_equal(np.isfinite(found), known)
    assert (np.abs(found - views[0].depth)[known] <= 0.51 * step[known]).all()
    with pytest.raises(ParameterError, match=r"disparities need baseline_focal .*views\.toml"):
        open_folder(plain, measured="disparity")


def edit(name: str, old: str, new: str):
    def change(folder: Path) -> None:
        path = folder / name
        assert old in path.read_text()
        path.write_text(path.read_text().replace(old, new))

    return change


def unlink(name: str):
    return lambda folder: (folder / name).unlink()


def overwrite(name: str, write):
    return lambda folder: write(folder / name)


def depths(values: np.ndarray):
    def change(folder: Path) -> None:
        (folder / "depth" / "1.png").unlink()
        np.save(folder / "depth" / "1.npy", values.astype(np.float32))

    return change


HALF_NEGATIVE = np.where(np.arange(768).reshape(24, 32) % 2, 1.0, -1.0)
BROKEN = {
    "unknown depth scale": (
        edit("views.toml", "depth_scale = 1000", ""),
        "0.png: 16-bit depth of unknown scale.*scale",
    ),
    "negative depth": (
        depths(HALF_NEGATIVE),
        r"1.npy: negative depth.*384 pixels, the first -1\.0 at row 0, column 0",
    ),
    "cut depth": (
        overwrite("depth/1.png", lambda path: path.write_bytes(path.read_bytes()[:200])),
        "depth/1.png: truncated",
    ),
    "not an image": (
        overwrite("depth/1.png", lambda path: path.write_text("hello")),
        "depth/1.png: not a readable image",
    ),
    "cut image": (
        overwrite("image/1.png", lambda path: path.write_bytes(path.read_bytes()[:-20])),
        "image/1.png: truncated",
    ),
    "image of other proportions": (
        overwrite("image/2.png", lambda path: images.write_png(path, np.zeros((9, 9), np.uint8))),
        "2.png: .*9 x 9",
    ),
    "no poses": (unlink("poses.txt"), r"poses.txt: no such file\. Add it"),
    "no intrinsics": (unlink("intrinsics.txt"), "intrinsics.txt: no such file"),
    "pose line missing": (edit("poses.txt", "\n1 ", "\n#1 "), r"poses.txt: no line of 1 of 3 views, the first is '1'"),
    "pose line twice": (edit("poses.txt", "\n1 ", "\n0 "), r"poses.txt: line 3 is the second of view '0'"),
    "pose line cut": (
        edit("poses.txt", "\n1 ", "\n1 2 3\n1 "),
        r"poses.txt: line 3 .*\(expected 12 or 16 numbers, got 2\)",
    ),
    "pose line of words": (
        edit("poses.txt", "\n1 ", "\n1 x"),
        "poses.txt: line 3 holds something that is not a number",
    ),
    "pose not rigid": (
        edit("poses.txt", "\n1 ", "\n1 2 0 0 0 0 1 0 0 0 0 1 0\n9 "),
        "view '1': pose is not rigid.*scale",
    ),
    "pose of NaN": (edit("poses.txt", "\n1 ", "\n1 nan 0 0 0 0 1 0 0 0 0 1 0\n9 "), "view '1': pose holds NaN"),
    "pose singular": (edit("poses.txt", "\n1 ", "\n1 0 0 0 0 0 1 0 0 0 0 1 0\n9 "), "poses.txt: pose is singular"),
    "focal length 0": (edit("intrinsics.txt", "52", "0"), "view '0': focal length is not positive"),
    "intrinsics cut": (
        edit("intrinsics.txt", "15.5 11.5", ""),
        r"intrinsics.txt: line 1 .*\(expected 4 or 9 numbers, got 2\)",
    ),
    "misspelt key": (edit("views.toml", "unit", "units"), "views.toml: unknown key 'units'; did you mean 'unit'?"),
    "not TOML": (edit("views.toml", "=", ""), "views.toml: not valid TOML"),
    "manifest value of wrong type": (edit("views.toml", "1000", '"mm"'), "depth_scale = 'mm': expected a number > 0"),
    "unknown quantity": (
        edit("views.toml", "unit", 'measured = "range"\nunit'),
        "measured = 'range': expected depth or disparity",
    ),
    "one stem twice": (overwrite("depth/1.npy", lambda path: np.save(path, np.ones((24, 32)))), "both 1.npy and 1.png"),
    "no depth": (lambda folder: [path.unlink() for path in (folder / "depth").iterdir()], "depth: no depth maps"),
}


@pytest.mark.parametrize(("damage", "message"), BROKEN.values(), ids=BROKEN)
def test_a_broken_folder_is_refused_in_one_line_that_names_the_place(plain, damage, message):
    damage(plain)
    with pytest.raises((FormatError, ParameterError), match=message) as refusal:
        read_all(plain)
    assert "\n" not in str(refusal.value)
    assert str(plain) in str(refusal.value)
