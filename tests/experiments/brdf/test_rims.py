"""Judges of rims on pictures of another kind: their figures, what they are asked, and the page."""

import numpy as np

from experiments.brdf import rims
from experiments.brdf.scenes import Case
from ipcli.models.brdf import surfaces
from ipcli.models.brdf.parameters import LibraryLearning
from ipcli.models.brdf.rim import Judge
from ipcli.models.brdf.training import RimLesson


def test_a_judge_is_right_and_sure_by_what_it_says():
    judge = Judge(np.array([0.0, 1.0, 0.0]), np.zeros(1), np.ones(1))  # P = 1 / (1 + exp(-x))
    scenes = RimLesson(np.array([[np.log(3)], [-np.log(3)]]), np.array([1.0, 1.0]))
    found = rims.judged(judge, "plain", 40.0, "mesh", scenes)
    assert (found.scenes, found.right) == (2, 0.5)
    np.testing.assert_allclose(found.brier, (0.25**2 + 0.75**2) / 2)


def test_what_is_asked_has_the_label_of_its_normals_bare_and_painted():
    ball = surfaces.march(surfaces.ellipsoid(np.full(3, 0.8)), 60)
    shade = np.nan_to_num(np.clip(ball.normals @ np.array([0.3, 0.4, 0.85]), 0, 1))[..., None].repeat(3, axis=-1)
    flat = np.where(ball.mask[..., None], [0, 0, 1.0], np.nan)
    cases = [Case(str(k), "round", shade, ball.mask, n, None) for k, n in enumerate((ball.normals, flat))]
    asked = rims.examined(cases, LibraryLearning())
    assert list(asked) == ["round", "round, painted"]
    np.testing.assert_array_equal(asked["round"].labels, [0, 1])
    np.testing.assert_array_equal(asked["round"].features[0], asked["round"].features[1])
    assert np.abs(asked["round, painted"].features[0] - asked["round"].features[0]).max() > 0.05


def test_judges_are_written(tmp_path):
    rims.write(tmp_path, [rims.Judged(lesson, 40.0, "mesh", 11, 0.8, 0.15) for lesson in ("plain", "in turn")])
    assert len((tmp_path / "rims.csv").read_text().splitlines()) == 3
    assert "0.15 (80 %)" in (tmp_path / "index.html").read_text(encoding="utf-8")
