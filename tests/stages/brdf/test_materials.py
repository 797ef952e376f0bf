"""The list of materials: what it accepts, and one line for each fault."""

import pytest

from ipcli.errors import FormatError
from ipcli.stages.brdf import materials

METAL = '[materials.a]\nmodel = "conductor"\neta = [1, 1, 1]\nkappa = [5, 5, 5]\nroughness = 0.2\n'
RED = '[materials.b]\nmodel = "plastic"\ndiffuse = [0.5, 0, 0]\neta = 1.5\nroughness = 0.1\n'


def listed(folder, text):
    path = folder / "m.toml"
    path.write_text(text)
    return materials.read(path)


def test_a_list_gives_reflectances_and_tells_metals(tmp_path):
    found = listed(tmp_path, METAL + RED)
    assert [materials.is_metal(entry) for entry in found.materials.values()] == [True, False]
    assert materials.brdf(found.materials["b"]).diffuse == (0.5, 0, 0)
    assert found.inputs(tmp_path / "m.toml") == (tmp_path / "m.toml",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[", "not valid TOML"),
        (METAL, "too few materials"),
        (METAL + RED.replace("plastic", "wood"), "unknown model 'wood'"),
        (METAL + RED.replace("eta", "eat"), "wrong keys"),
        (METAL + RED.replace("0.1", "7"), "roughness: wrong value"),
        (METAL + RED.replace("[0.5, 0, 0]", "[0.5, nan, 0]"), "diffuse: wrong value"),
        (METAL + RED + '[materials.c]\nmodel = "table"\nfile = "x.binary"\n', "no such file"),
        (METAL + RED + '[probes]\nfiles = ["x.hdr"]\n', "no such file"),
        (METAL + RED + "[lights]\n", "unknown section 'lights'"),
    ],
)
def test_faults_are_told(tmp_path, text, message):
    with pytest.raises(FormatError, match=message):
        listed(tmp_path, text)
