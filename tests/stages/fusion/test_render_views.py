"""render-views from a mesh file to its artefact."""

import numpy as np
import pytest

from ipcli import schema
from ipcli.errors import FormatError, NoSolution, ParameterError
from ipcli.geometry import raycast
from ipcli.io.files import h5
from ipcli.io.views import layouts
from ipcli.params import Run
from ipcli.stages.fusion import render_views
from ipcli.stages.fusion.parameters import RenderViews

SMALL = {"width": 80, "height": 60, "focal": 72.0}


@pytest.fixture(scope="module", params=[".ply", ".obj"])
def mesh(request, tmp_path_factory):
    import trimesh

    path = tmp_path_factory.mktemp("mesh") / f"torus{request.param}"
    trimesh.creation.torus(1.0, 0.3).export(path)
    return path


def run(mesh, folder, seed=0, **params):
    output = folder / f"{seed}.views.h5"
    render_views.run(mesh, output, RenderViews(**SMALL | params), Run(seed=seed, overwrite=True))
    return output


def test_the_artefact_is_sound_and_holds_the_truth_under_the_noise(mesh, tmp_path):
    output = run(mesh, tmp_path, noise="laplace:0.05", views=3, up="z")
    schema.validate(schema.kind("views"), h5.read(output, "views").arrays)
    sequence = layouts.open_views(output)
    assert sequence.names == ("0", "1", "2")
    assert sequence.unit == "m.u."
    assert sequence.measured == "depth"
    assert sequence.baseline_focal == pytest.approx(72 * 3 * np.sin(np.pi / 72))
    view = sequence.load("1")
    np.testing.assert_array_equal(np.isfinite(view.depth), np.isfinite(view.truth))
    assert np.nanmean(np.abs(view.depth - view.truth)) == pytest.approx(0.05, rel=0.15)
    np.testing.assert_array_equal(view.cam_from_world, raycast.orbit(1, 1.0)[0])


def test_repeats_give_the_same_bytes_and_noise_depends_on_view_and_seed(mesh, tmp_path):
    first = run(mesh, tmp_path, noise="gauss:0.05", views=3)
    before = first.read_bytes()
    assert run(mesh, tmp_path, noise="gauss:0.05", views=3).read_bytes() == before
    other = layouts.open_views(run(mesh, tmp_path, seed=1, noise="gauss:0.05", views=3))
    noise = [
        view.depth - view.truth
        for view in (layouts.open_views(first).load("0"), layouts.open_views(first).load("1"), other.load("0"))
    ]
    assert all(not np.array_equal(noise[a], noise[b], equal_nan=True) for a, b in [(0, 1), (0, 2)])


def test_along_a_strip_the_step_is_the_baseline(mesh, tmp_path):
    sequence = layouts.open_views(run(mesh, tmp_path, path="strip", spacing=0.5, views=11, focal=9000.0))
    assert len(sequence.names) == 11
    assert sequence.names[5] == "05"
    assert sequence.baseline_focal == pytest.approx(9000 * 0.5)
    steps = np.diff([np.linalg.inv(sequence.load(name).cam_from_world)[0, 3] for name in sequence.names])
    np.testing.assert_allclose(steps, 0.5)
    assert np.nanmin(sequence.load("05").truth) == pytest.approx(300 - 0.6, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("x.stl", b"", "expected .ply or .obj or .off, got .stl"),
        ("x.ply", b"ply\nformat ascii 1.0\nelement ver", "cannot be read"),
        ("x.obj", b"v 0 0 0\nv 0 0 1\n", "holds no triangles|cannot be read"),
    ],
)
def test_files_that_are_no_mesh_are_refused_by_name(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=message) as caught:
        run(tmp_path / name, tmp_path)
    assert name in str(caught.value)


def test_a_camera_that_sees_nothing_finds_no_solution_and_odd_noise_is_refused(mesh, tmp_path):
    with pytest.raises(ParameterError, match="expected laplace:SCALE"):
        run(mesh, tmp_path, noise="much")
    with pytest.raises(NoSolution, match="sees nothing"):
        run(mesh, tmp_path, path="strip", focal=50_000.0, width=8, height=8)  # into the hole of the torus
