import pytest

from ipcli.errors import ParameterError
from ipcli.stages.saliency import sets
from tests.fixtures.fixation_sets import write_pictures, write_surfaces


def test_sets_of_one_kind_join_and_names_must_differ(tmp_path):
    first = write_pictures(tmp_path / "a", 1)
    assert sets.read((first,)).names == ("p0",)
    with pytest.raises(ParameterError, match="'p0' is in the sets twice"):
        sets.read((first, first))
    with pytest.raises(ParameterError, match="features of their own"):
        sets.read((first, write_surfaces(tmp_path / "b", 1)))


def test_all_files_of_a_set_are_its_inputs(tmp_path):
    folder = write_pictures(tmp_path, 2)
    assert {path.name for path in sets.inputs((folder,))} == {"fixations.csv", "p0.png", "p1.png"}


def test_cases_have_their_fixations_on_the_grid(tmp_path):
    known = sets.read((write_pictures(tmp_path, 1),))
    (one,) = sets.cases(known.pictures, "serial")
    assert one.shape == (150, 200)
    assert one.fixations.max(axis=0).tolist() < [200, 150]
