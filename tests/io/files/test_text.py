"""Text tables, files by stem, trajectories, camera matrices, and images at the size of the depth."""

import numpy as np
import open3d
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ipcli.errors import FormatError, ParameterError
from ipcli.io.files import text
from ipcli.io.files.images import write_png
from tests.fixtures.errors import check_message


def write(path, content):
    path.write_text(content, encoding="utf-8")
    return path


def refused(call, *mentioned, error=FormatError):
    with pytest.raises(error) as raised:
        call()
    check_message(raised.value, *mentioned)


def test_comments_and_empty_lines_are_left_out_and_lines_keep_their_numbers(tmp_path):
    path = write(tmp_path / "a.txt", "# head\n\n 1 2 # end\n   \n3\n#4\n")
    assert text.comment_free(path) == [(3, "1 2"), (5, "3")]


def test_a_file_that_is_absent_or_no_text_is_named(tmp_path):
    refused(lambda: text.read_text(tmp_path / "no.txt"), "no.txt: no such file")
    (tmp_path / "b.txt").write_bytes(b"\xff\xfe1 2")
    refused(lambda: text.read_text(tmp_path / "b.txt"), "b.txt: not a readable text file", "UTF-8")
    refused(lambda: text.read_text(tmp_path), str(tmp_path))


def test_files_come_by_stem_in_order_and_hidden_ones_and_others_do_not(tmp_path):
    for name in ("b.PNG", "a.jpg", ".c.png", "d.txt", "e"):
        (tmp_path / name).touch()
    assert list(text.by_stem(tmp_path, text.IMAGES).items()) == [("a", tmp_path / "a.jpg"), ("b", tmp_path / "b.PNG")]
    assert text.by_stem(tmp_path / "none", text.IMAGES) == {}


def test_two_files_of_one_stem_are_refused_by_name(tmp_path):
    for name in ("a.png", "a.jpg"):
        (tmp_path / name).touch()
    refused(lambda: text.by_stem(tmp_path, text.IMAGES), "both a.jpg and a.png")


def test_a_folder_that_is_not_there_is_named(tmp_path):
    assert text.require_folder(tmp_path) == tmp_path
    refused(lambda: text.require_folder(tmp_path / "none"), "none: no such folder")


@given(st.lists(st.lists(st.floats(allow_nan=False), min_size=3, max_size=3), min_size=1, max_size=4))
def test_a_matrix_comes_back_to_the_last_bit(tmp_path_factory, rows):
    path = write(
        tmp_path_factory.mktemp("matrix") / "m.txt", "".join(" ".join(map(repr, row)) + " # row\n" for row in rows)
    )
    np.testing.assert_array_equal(text.read_matrix(path, (len(rows), 3)), rows)


@pytest.mark.parametrize(
    ("content", "mentioned"),
    [
        ("1 2 3\n1 2\n", ("line 2 is cut or too long", "expected 3 numbers", "got 2")),
        ("1 2 3\n# c\n1 x 3\n", ("line 3 holds something that is not a number", "got 1 x 3")),
        ("1 2 3\n", ("wrong number of rows", "expected 2", "got 1")),
        ("", ("wrong number of rows", "got 0")),
    ],
)
def test_a_matrix_of_another_shape_is_refused_and_the_line_named(tmp_path, content, mentioned):
    path = write(tmp_path / "m.txt", content)
    refused(lambda: text.read_matrix(path, (2, 3)), "m.txt", *mentioned)


def test_a_pose_without_inverse_names_its_file(tmp_path):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec((0.3, -0.2, 1.0)).as_matrix()
    pose[:3, 3] = (1, 2, 3)
    turned = pose[:3, :3].T
    found = text.inverse(tmp_path / "p.txt", pose)
    np.testing.assert_allclose(found[:3], np.c_[turned, -turned @ pose[:3, 3]], atol=1e-14)
    refused(lambda: text.inverse(tmp_path / "p.txt", np.diag([1.0, 1, 0, 1])), "p.txt: pose is singular")


def test_trajectories_are_those_that_open3d_writes(tmp_path):
    """Open3D writes the inverse of what it holds: its extrinsics are cam_from_world, the file's world_from_cam."""
    trajectory, rng = open3d.camera.PinholeCameraTrajectory(), np.random.default_rng(1)
    cameras, poses = [], {}
    for frame in range(4):
        camera, pose = open3d.camera.PinholeCameraParameters(), np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.random(random_state=frame).as_matrix(), rng.normal(size=3)
        camera.intrinsic = open3d.camera.PinholeCameraIntrinsic(640, 480, 500, 500, 319.5, 239.5)
        camera.extrinsic = np.linalg.inv(pose)
        cameras.append(camera)
        poses[frame] = pose
    trajectory.parameters = cameras
    open3d.io.write_pinhole_camera_trajectory(str(tmp_path / "t.log"), trajectory)
    found = text.read_trajectory_log(tmp_path / "t.log")
    assert list(found) == list(poses)
    for frame, pose in poses.items():
        np.testing.assert_allclose(found[frame], pose, atol=1e-7)


@pytest.mark.parametrize(
    ("content", "mentioned"),
    [
        ("", "blocks of 5 lines"),
        ("0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n", "got 4 lines"),
        ("0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "line 1 is cut"),
        ("nan 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "line 1 has no frame number"),
        ("1e400 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "line 1 has no frame number"),
        ("0 0 1\n1 0 0 0\n0 1 0\n0 0 1 0\n0 0 0 1\n", "line 3 is cut"),
    ],
)
def test_a_cut_trajectory_is_refused(tmp_path, content, mentioned):
    path = write(tmp_path / "t.log", content)
    refused(lambda: text.read_trajectory_log(path), "t.log", mentioned)


def test_a_camera_is_four_numbers_or_nine():
    matrix = [[500, 0, 320], [0, 510, 240], [0, 0, 1]]
    np.testing.assert_array_equal(text.camera_matrix((500, 510, 320, 240)), matrix)
    np.testing.assert_array_equal(text.camera_matrix(np.ravel(matrix)), matrix)
    refused(lambda: text.camera_matrix((1, 2, 3)), "fx,fy,cx,cy", "got 3 numbers", error=ParameterError)


def test_an_image_is_averaged_to_the_size_of_its_depth(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (8, 12, 3), dtype=np.uint8)
    write_png(tmp_path / "i.png", image)
    assert text.image_at(None, (8, 12)) is None
    np.testing.assert_array_equal(text.image_at(tmp_path / "i.png", (8, 12)), image)
    halved = image.reshape(4, 2, 6, 2, 3).mean(axis=(1, 3))
    assert np.abs(text.image_at(tmp_path / "i.png", (4, 6)) - halved).max() <= 0.5
    refused(lambda: text.image_at(tmp_path / "i.png", (6, 6)), "i.png", "expected 6 x 6", "got 12 x 8")


@pytest.mark.parametrize(("width", "taken"), [(100, True), (101, True), (103, False), (99, True), (97, False)])
def test_proportions_may_differ_by_two_percent(tmp_path, width, taken):
    write_png(tmp_path / "i.png", np.zeros((50, width, 3), np.uint8))
    if taken:
        assert text.image_at(tmp_path / "i.png", (100, 200)).shape == (100, 200, 3)
    else:
        refused(lambda: text.image_at(tmp_path / "i.png", (100, 200)), "proportions")


def test_the_mark_of_an_encoding_is_no_text(tmp_path):
    path = tmp_path / "a.txt"
    for encoding in ("utf-8", "utf-8-sig"):
        path.write_text("été\n", encoding=encoding)
        assert text.read_text(path) == text.read_any_text(path) == "été\n"


def test_old_texts_are_read_in_the_encoding_that_fits(tmp_path):
    path = tmp_path / "a.txt"
    for encoding in ("utf-16", "latin-1"):
        path.write_bytes("été\n1 2\n".encode(encoding))
        assert text.read_any_text(path) == "été\n1 2\n"
    path.write_bytes("上\n".encode())
    assert text.read_any_text(path) == "上\n"


@pytest.mark.parametrize("end", [b"\x1a", b"\x1a\r\n", b"\0\0", b"\x1a\0\0\0"])
def test_what_dos_put_after_the_end_is_left_out(tmp_path, end):
    (tmp_path / "a.txt").write_bytes(b"1 2\n3 4\n" + end)
    assert text.read_any_text(tmp_path / "a.txt") == "1 2\n3 4\n"


def test_whole_numbers_are_ascii_digits_of_a_length_that_occurs():
    assert text.whole("0012") == 12
    assert [text.whole(word) for word in ("", "-1", "1.0", "²", "٣", "9" * 5000, "x")] == [None] * 7
