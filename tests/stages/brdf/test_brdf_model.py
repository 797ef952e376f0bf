"""brdf-model from the shell: all files, their frames, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from ipcli.cli.main import main
from ipcli.errors import FormatError
from ipcli.io.files import h5, images, ply
from ipcli.io.materials import photographs
from ipcli.stages.brdf import brdf_model
from tests.fixtures import brdf_scenes


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("brdf")
    library = brdf_scenes.library(folder / "library.h5")
    photo, mask, normals, height = brdf_scenes.ball(folder)
    truth = ("--true-normals", str(normals), "--true-height", str(height))
    words = (
        str(library),
        str(photo),
        "--mask",
        str(mask),
        *truth,
        "--width-mm",
        "80",
        "--normals",
        "directx",
        "--rim",
        "solid",
    )
    assert main(["brdf-model", *words, *brdf_scenes.FAST, "-o", str(folder / "egg.h5"), "--quiet"]) == 0
    return folder


def test_the_console_tells_its_figures(made):
    told = brdf_model.summary(made / "egg.h5")
    metrics = h5.read(made / "egg.h5", "brdf-object").arrays["metrics"]
    assert next(iter(told.items())) == ("output", made / "egg.h5")
    assert told["N-MAE, rad"] == round(float(metrics[0, 0]), 4)
    assert str(told["cut edge"]) == "no, a rim (probability 0.00)"
    assert str(told["settled by the picture"]) == "convex or concave: no, it ties"
    assert str(told["material"]).endswith(", of 5 in the library)")
    assert brdf_model.summary(made / "none.h5") == {"output": made / "none.h5"}


def test_the_surface_is_better_than_flat_and_its_errors_are_told(made):
    arrays = h5.read(made / "egg.h5", "brdf-object").arrays
    errors = dict(zip(arrays["metric_rows"], arrays["metrics"][:, 0], strict=True))
    assert errors["this surface"] < 0.5 * errors["flat"]
    assert np.isfinite(arrays["metrics"]).all()
    inside = arrays["mask"] > 0
    np.testing.assert_allclose(np.linalg.norm(arrays["normals"][inside], axis=-1), 1, atol=1e-5)
    assert np.isnan(arrays["height"][~inside]).all()


def test_normal_map_mesh_and_relief_are_of_the_surface(made):
    arrays = h5.read(made / "egg.h5", "brdf-object").arrays
    inside = arrays["mask"] > 0
    read = photographs.read_normals(made / "egg.normals.png", "directx", inside.shape)
    np.testing.assert_allclose(read[inside], arrays["normals"][inside], atol=1e-4)
    mesh = ply.read(made / "egg.ply")
    assert len(mesh.vertices) == inside.sum()
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(
        80 * (1 - 1 / np.ptp(np.flatnonzero(inside.any(axis=0)) + 1)), rel=0.03
    )
    trimesh = pytest.importorskip("trimesh")
    relief = trimesh.load(made / "egg.stl")
    assert relief.is_watertight


def test_the_page_shows_the_tie_and_the_errors(made):
    text = (made / "egg.html").read_text(encoding="utf-8")
    assert "does not tell convex from concave" in text
    assert "inflation" in text
    assert "<script" not in text


def test_a_photograph_beside_the_output_is_not_replaced(made):
    """The normal map of egg.h5 would be egg.png, which is the input here: it has a name of its own."""
    assert images.read_stored(made / "egg.png").dtype == np.uint8


@pytest.mark.parametrize(("change", "code"), [("mask", 1), ("small", 3), ("library", 1)])
def test_bad_input_fails_in_one_line(made, tmp_path, capsys, change, code):
    photo, mask, _, _ = brdf_scenes.ball(tmp_path, 20 if change == "small" else 48)
    if change == "mask":
        images.write_png(mask, np.zeros((48, 48), np.uint8))
    library = made / "egg.h5" if change == "library" else made / "library.h5"
    assert main(["brdf-model", str(library), str(photo), "--mask", str(mask), "-o", str(tmp_path / "x.h5")]) == code
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_what_no_relief_was_compared_for_settles_nothing(made, tmp_path):
    words = [str(made / "library.h5"), str(made / "egg.png"), "--mask", str(made / "egg.mask.png"), "--rim", "sheet"]
    assert main(["brdf-model", *words, *brdf_scenes.FAST, "-o", str(tmp_path / "x.h5"), "--quiet"]) == 0
    told = brdf_model.summary(tmp_path / "x.h5")
    assert str(told["settled by the picture"]) == "convex or concave: not asked"
    assert str(told["cut edge"]) == "yes (probability 1.00)"


def test_given_normals_are_integrated(made):
    words = [str(made / "library.h5"), str(made / "egg.png"), "--mask", str(made / "egg.mask.png")]
    truth = ["--normals-from", str(made / "egg.normals.npy"), "--true-height", str(made / "egg.npy")]
    assert main(["brdf-model", *words, *truth, "-o", str(made / "given.h5"), "--quiet"]) == 0
    arrays = h5.read(made / "given.h5", "brdf-object").arrays
    errors = dict(zip(arrays["metric_rows"], arrays["metrics"], strict=True))
    assert errors["this surface"][0] < 0.1
    assert errors["this surface"][2] < 0.6


def test_a_mask_along_the_border_of_the_picture_is_said_on_the_console(made, tmp_path, capsys):
    """The egg without its lower half."""
    for name in ("egg.png", "egg.mask.png"):
        images.write_png(tmp_path / name, images.read_stored(made / name)[:24])
    words = [str(made / "library.h5"), str(tmp_path / "egg.png"), "--mask", str(tmp_path / "egg.mask.png")]
    assert main(["brdf-model", *words, *brdf_scenes.FAST, "--rim", "solid", "-o", str(tmp_path / "half.h5")]) == 0
    assert "pixels of the picture's border" in capsys.readouterr().err
    assert "that cut is taken for an outline" in (tmp_path / "half.html").read_text(encoding="utf-8")


def test_a_list_of_materials_or_a_lacking_library_is_told_from_a_library(made, tmp_path, capsys):
    (tmp_path / "materials.toml").write_text("[materials]\n")
    words = [str(made / "egg.png"), "--mask", str(made / "egg.mask.png"), "-o", str(tmp_path / "x.h5")]
    assert main(["brdf-model", str(tmp_path / "materials.toml"), *words]) == 1
    assert "a list of materials, not a library" in (told := capsys.readouterr().err)
    assert "brdf-train materials.toml -o materials.h5" in told
    assert main(["brdf-model", *words]) == 2
    assert "two files are needed, LIBRARY (of brdf-train) and PHOTO" in capsys.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        lambda a: {"rim_features": a["rim_features"][::-1]},
        lambda a: {"material_features": np.char.add(a["material_features"], "2")},
        lambda a: {"rim_weights": a["rim_weights"][:-1]},
        lambda a: {"material_spread": 0 * a["material_spread"]},
        lambda a: {key: a[key][:0] for key in ("charts", "chart_material", "chart_probe", "chart_heading")},
    ],
    ids=["order", "names", "weights", "spread", "empty"],
)
def test_a_library_whose_parts_do_not_go_together_is_refused(tmp_path, change):
    found = h5.read(brdf_scenes.library(tmp_path / "lib.h5"), "brdf-library")
    assert brdf_model.library_of(tmp_path / "lib.h5").probes
    h5.write(tmp_path / "bad.h5", "brdf-library", dict(found.arrays) | change(found.arrays), found.provenance)
    with pytest.raises(FormatError, match="cannot be used"):
        brdf_model.library_of(tmp_path / "bad.h5")
