"""Pages in which a surface can be turned: named, explained, the same bytes, and drawn by a real browser."""

import os
import shutil
import subprocess

import cv2
import numpy as np
import pytest

from ipcli.io.meshes import turntable

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
TRIANGLE = np.array([[-1.0, -1, -3], [1, -1, -3], [0, 1, -3]]), np.array([[0, 1, 2]])
RED = np.tile(np.array([[220, 30, 30]], np.uint8), (3, 1))


def page(title="fuse-depth: a.h5", **more):
    scene = turntable.surface_scene(*TRIANGLE, RED)
    return turntable.turning_page(scene, title, "A triangle", {"left < right": (1, 2, 3)}, **more)


def test_the_page_has_the_name_of_the_command_and_the_file_a_legend_and_a_hint():
    html = page("fuse-depth: <a>.h5")
    assert "<title>fuse-depth: &lt;a&gt;.h5</title>" in html
    assert "threejs viewer" not in html
    assert "left &lt; right" in html
    assert "rgb(1,2,3)" in html
    assert turntable.HINT in html


def test_the_viewer_is_still_the_one_that_we_change():
    html = page()
    for theirs, ours in turntable.CHANGES:
        assert ours in html
        assert theirs not in html.replace(ours, "")


def test_the_same_scene_gives_the_same_bytes():
    assert page() == page()


def test_the_first_view_sees_everything_upright():
    points = np.random.default_rng(0).uniform((-3, 0, -1), (5, 2, 7), (500, 3))
    pose = turntable.looking_from(points, np.array([1.0, 0.4, 1.0]), field=40.0)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    assert pose[1, 1] > 0.5  # up stays up
    seen = (points - pose[:3, 3]) @ pose[:3, :3]
    assert (seen[:, 2] < 0).all()
    assert (np.abs(seen[:, :2]) <= -seen[:, 2:] * np.tan(np.radians(20))).all()


@pytest.mark.skipif(BROWSER is None, reason="no browser")
def test_a_real_browser_draws_the_surface_from_the_first_view(tmp_path):
    (tmp_path / "a.turn.html").write_text(page(from_camera=np.eye(4), field=60.0), encoding="utf-8")
    drawn = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--virtual-time-budget=4000"]
    quiet = ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
    words = [BROWSER, "--headless", "--no-sandbox", *drawn, *quiet, f"--user-data-dir={tmp_path / 'profile'}"]
    words += ["--window-size=400,400", f"--screenshot={tmp_path / 'a.png'}", "--enable-logging=stderr"]
    said = subprocess.run([*words, (tmp_path / "a.turn.html").as_uri()], capture_output=True, text=True, timeout=120)
    assert "Uncaught" not in said.stderr
    assert os.path.exists(tmp_path / "a.png")
    picture = cv2.imread(str(tmp_path / "a.png")).astype(int)
    red = (picture[..., 2] > 120) & (picture[..., 1] < 90) & (picture[..., 0] < 90)
    assert 0.02 < red.mean() < 0.6
    as_given = np.abs(np.median(picture[red], axis=0)[::-1] - RED[0]) <= 8
    assert as_given.all()  # neither burnt out nor dark where it faces the viewer
    rows = np.flatnonzero(red.any(axis=1))
    wide = red.sum(axis=1)
    assert wide[rows[-5]] > wide[rows[5]]  # the triangle stands on its base
