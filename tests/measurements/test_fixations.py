import numpy as np

from ipcli.measurements.fixations import FixatedPicture, FixatedSurface, FixationSet


def test_a_set_names_its_pictures_and_then_its_surfaces():
    picture = FixatedPicture("a", lambda: np.zeros((2, 2, 3), np.uint8), np.zeros((0, 2)), np.zeros(0, np.int64))
    surface = FixatedSurface("b", np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1), np.zeros(1, bool))
    assert FixationSet((picture,), (surface,)).names == ("a", "b")
