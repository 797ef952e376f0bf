"""The projects of photographs: parts that are shown, names that are translated, parents that are there."""

import tomllib

import numpy as np

from experiments.animal.photos import page


def test_a_project_has_the_parts_that_the_masks_show(tmp_path, monkeypatch):
    labels = np.zeros((8, 8), np.int16)
    labels[:3], labels[3:6], labels[6:] = 1, 2, 3
    monkeypatch.setattr("ipcli.io.parts.pascal.read", lambda path, which: (("neck", "beak", "lfoot"), labels))
    bird = page.SUBJECTS["flamingo"]
    told = tomllib.loads(page.project("bird", bird, tmp_path))
    assert told["parts"] == {"neck": "", "head": "neck", "leg_L": ""}  # no torso: its children are roots
    (image,) = told["images"]
    assert (image["object"], image["view"]) == (bird.number, "right")
    assert image["rename"] == {"beak": "head", "lfoot": "leg_L"}


def test_every_name_is_translated_to_a_part():
    for subject in page.SUBJECTS.values():
        assert set(subject.rename.values()) <= set(subject.parts)
        assert {parent for parent in subject.parts.values() if parent} <= set(subject.parts)
    assert page.LEGS["rbpa"] == "back_leg_R"
