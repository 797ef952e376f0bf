"""Pictures by Mitsuba: a convex object as our own renderer has it, a hollow one brighter by inter-reflection."""

import numpy as np
import pytest

from experiments.brdf import traced
from ipcli.models.brdf import surfaces
from ipcli.models.brdf.light import key_and_fill, probe
from ipcli.models.brdf.materials import Conductor, Matte, Network, Plastic
from ipcli.models.brdf.reflectance import charts, shade
from ipcli.rng import stream

BRASS = Conductor((0.452, 0.527, 0.947), (3.345, 2.765, 1.920), 0.2)
SIDE = 40


@pytest.mark.parametrize(
    ("brdf", "light", "tolerance"),
    [(Matte((0.5, 0.3, 0.2)), "constant", 0.01), (Matte((0.5, 0.3, 0.2)), "studio", 0.02), (BRASS, "studio", 0.03)],
)
def test_a_convex_object_looks_as_our_own_renderer_has_it(brdf, light, tolerance):
    """Mean difference within 70 degrees of the view, over the mean brightness; facets of metal shadow each other by
    another formula there.
    """
    pytest.importorskip("mitsuba")
    solid = surfaces.ellipsoid(np.array([0.8, 0.6, 0.7]))
    lamp = traced.equirectangular(key_and_fill(stream(0, "test", "light")).radiance)
    image = lamp if light == "studio" else np.ones_like(lamp)
    made = surfaces.march(solid, SIDE)
    within = np.nan_to_num(made.normals[..., 2]) > np.cos(np.radians(70))
    seen, own = traced.trace(traced.meshed(solid), brdf, image, SIDE, 144), np.zeros((SIDE, SIDE, 3))
    own[within] = shade(charts(brdf, [probe(image)])[0], made.normals[within])

    def apart(other):
        return np.abs(other - own)[within].mean() / own[within].mean()

    assert apart(seen) < tolerance
    if light == "studio":  # it has an up and a right
        assert min(apart(seen[::-1]), apart(seen[:, ::-1])) > 5 * tolerance


def test_light_between_the_walls_of_a_bowl_is_traced():
    pytest.importorskip("mitsuba")
    bowl, image = traced.meshed(surfaces.bowl(0.9, 0.2, 0.0)), np.ones((16, 32, 3))
    once, often = (traced.trace(bowl, Matte((0.8,) * 3), image, 24, 36, n)[12, 12] for n in (1, None))
    assert (often > 1.3 * once).all()


def test_what_is_measured_has_no_plugin():
    assert traced.plugin(Plastic((0.5, 0.1, 0.1), 1.5, 0.1))["type"] == "roughplastic"
    with pytest.raises(ValueError, match="Network"):
        traced.plugin(Network({}))


def test_a_mesh_lies_on_its_solid_and_faces_outward():
    solid = surfaces.ellipsoid(np.array([0.8, 0.6, 0.7]))
    vertices, faces = traced.meshed(solid)
    assert np.abs(solid(vertices)).max() < 2e-3
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 0.8 * 0.6 * 0.7, rel=0.01)


def test_what_was_traced_is_summed_up_by_kind(tmp_path):
    found = [
        traced.Traced("a brass", "Metals", 0.4, 0.3, 0.36, 0.1),
        traced.Traced("b brass", "Metals", 0.2, 0.2, 0.3, 0.1),
    ]
    traced.write(tmp_path, found)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "-17 %" in text
    assert "+10 %" in text
    assert "1 of 2" in text
    assert len((tmp_path / "traced.csv").read_text().splitlines()) == 3
