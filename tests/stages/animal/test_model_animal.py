"""The stage: heights come back from their artefact as they were, and a model keeps its size."""

from contextlib import suppress

import numpy as np
import pytest

from ipcli.errors import IpcliError, ParameterError
from ipcli.io.files import h5
from ipcli.io.parts import project
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.parameters import Inflation, Modelling, Volume
from ipcli.params import Run
from ipcli.stages.animal import model_animal
from ipcli.stages.animal.check_mesh import check
from ipcli.stages.animal.parameters import ModelAnimal
from tests.fixtures import limbs


def test_heights_come_back_from_their_artefact(tmp_path):
    animal = project.read(limbs.write_project(tmp_path, longest=60))
    params = Modelling(Inflation(triangles=100))
    arrays = model_animal.aspects_artefact(animal, params, lambda share, what: None)
    h5.write(tmp_path / "a.h5", "animal-aspects", arrays, {})
    found = model_animal.read_heights(tmp_path / "a.h5", {image.name: image for image in animal.images})
    lifted = lift_all(animal.images, animal.tree, params.inflation)
    assert found.keys() == lifted.keys()
    for key, heights in found.items():
        inside = lifted[key].mask
        assert np.array_equal(heights[inside], lifted[key].picture[inside])


def test_an_output_that_is_no_model_is_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"\.glb"):
        model_animal.check_suffix(tmp_path / "a.fbx")


@pytest.mark.parametrize(("views", "count"), [(1, 1), (2, 0)])
def test_one_view_alone_is_said_to_guess_the_depth(tmp_path, caplog, views, count):
    path = limbs.write_project(tmp_path, ("left", "front")[:views], longest=24)
    with suppress(IpcliError):  # the steps themselves are not wanted
        model_animal.run(path, tmp_path / "x.glb", ModelAnimal(), Run(dry_run=True))
    assert sum("one view alone: the depth" in record.message for record in caplog.records) == count


def test_the_union_of_the_aspects_is_closed_after_it_was_saved_and_read(tmp_path):
    source = limbs.write_project(tmp_path, longest=60)
    params = Modelling(Inflation(triangles=100), Volume(merge="union", field="ipf", voxels=24, steps=4))
    model_animal.run(source, tmp_path / "x.stl", ModelAnimal(modelling=params), Run())
    facts = check(tmp_path / "x.stl")
    assert facts["watertight"]
    assert facts["volume"] > 0.3


def test_another_image_of_the_same_side_is_registered_and_merged(tmp_path):
    source = limbs.add_same_side(limbs.write_project(tmp_path, ("left", "front"), longest=60))
    animal = project.read(source)
    params = Modelling(Inflation(triangles=100))
    arrays = model_animal.aspects_artefact(animal, params, lambda share, what: None)
    h5.write(tmp_path / "a.h5", "animal-aspects", arrays, {})
    assert arrays["registrations/0000/images"].tolist() == ["left", "again"]
    turned = arrays["registrations/0000/transform"][:2, :2]
    assert np.degrees(np.arctan2(turned[0, 1], turned[0, 0])) == pytest.approx(12.0, abs=2.0)
    assert np.sqrt(np.linalg.det(turned)) == pytest.approx(1 / 1.1, abs=0.03)
    assert arrays["registrations/0000/is_used"]
    found = model_animal.read_heights(tmp_path / "a.h5", {image.name: image for image in animal.images})
    alone = lift_all(animal.images, animal.tree, params.inflation)
    assert not np.array_equal(found["left", 0], alone["left", 0].picture)
    inside = alone["front", 0].mask
    assert np.array_equal(found["front", 0][inside], alone["front", 0].picture[inside])
