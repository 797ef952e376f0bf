"""The symmetry prior: which parts and views are paired, and that a limb and its partner meet halfway."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.animal import symmetry
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.aspects import inflate
from ipcli.models.animal.parameters import Inflation, Registration


def test_partners_are_told_by_their_names():
    names = ["torso", "front_leg_L", "front_leg_R", "left ear", "right ear", "back_leg_L", "lion"]
    assert symmetry.partners(names) == {1: 2, 2: 1, 3: 4, 4: 3}


def test_views_along_one_line_show_partners_alike_or_mirrored():
    assert symmetry.is_mirrored("left", "left") is False
    assert symmetry.is_mirrored("left", "right") is True
    assert symmetry.is_mirrored("front", "front") is True
    assert symmetry.is_mirrored("front", "back") is False
    assert symmetry.is_mirrored("left", "front") is None


def test_a_limb_and_its_mirrored_partner_meet_halfway():
    rows, columns = np.mgrid[:30, :44]
    mask = (np.abs(rows - 14 - 0.004 * (columns - 4) ** 2) < 6 - 0.08 * columns) & (columns > 3) & (columns < 40)
    limb, partner = (inflate(own, Inflation(triangles=80)) for own in (mask, mask[:, ::-1]))
    thick = replace(partner, heights=1.3 * partner.heights, picture=np.float32(1.3) * partner.picture)
    images = [PartImage(view, np.where(own, k + 1, 0), view) for k, (view, own) in enumerate(
        (("left", mask), ("right", mask[:, ::-1])))]  # fmt: skip
    found, residuals = symmetry.shared(
        {("left", 0): limb, ("right", 1): thick}, images, ("leg_L", "leg_R"), Registration()
    )
    assert max(residuals) < 0.2
    high = limb.picture > 2
    assert np.median(found["left", 0].picture[high] / limb.picture[high]) == pytest.approx(1.15, abs=0.05)
    _, unlike = symmetry.met(limb, thick, False, Registration())  # not mirrored: the bend is the other way
    assert unlike > 1.5 * max(residuals)
