"""A symmetry prior, for trial: the left and the right limb of a pair have one shape.

Seen along one line, a limb and its partner have one outline, or each other's mirrored. So the partner's best aspect is
laid over the limb's own by the registration of 6.3.2, which allows for another pose within the image, and the limb
takes the mean thickness of both.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.geometry.orthographic import of_view
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal.aspects import Aspect
from ipcli.models.animal.merging import MOST_RESIDUAL, corrected
from ipcli.models.animal.parameters import Registration
from ipcli.models.animal.registration import AspectSurface, register

OTHER_SIDE = {"l": "r", "r": "l", "left": "right", "right": "left"}  # words of a part's name
LINE = 0.99  # cosine between views that count as along one line
MIRROR = np.diag([1.0, -1.0, 1.0])  # of the animal, its left to its right

Key = tuple[str, int]  # name of the image and part


def partners(names: Sequence[str]) -> dict[int, int]:
    """The part on the other side of each part that has one, by their names: front_leg_L, or "left ear"."""
    words = [re.split(r"[^a-z0-9]+", name.lower()) for name in names]
    mirrored = [[OTHER_SIDE.get(word, word) for word in own] for own in words]
    return {k: words.index(other) for k, other in enumerate(mirrored) if other != words[k] and other in words}


def is_mirrored(first: str, second: str) -> bool | None:
    """Whether a limb in one view and its partner in another are mirror images; None unless both look along one line."""
    first_from_second = of_view(first) @ MIRROR @ of_view(second).T
    if abs(first_from_second[2, 2]) < LINE:
        return None
    return bool(np.linalg.det(first_from_second[:2, :2]) < 0)


def shared(
    aspects: Mapping[Key, Aspect], images: Sequence[PartImage], names: Sequence[str], params: Registration
) -> tuple[dict[Key, Aspect], list[float]]:
    """All aspects, those of limbs merged with their partners', and the residual of each registration."""
    shown = {image.name: image for image in images}
    partner = partners(names)
    result, residuals = dict(aspects), []
    for name, part in [key for key in aspects if key[1] in partner and shown[key[0]].view]:
        found = [
            (shown[other].mask(partner[part]).sum(), other, flipped)
            for other, its in aspects
            if its == partner[part] and shown[other].view
            if (flipped := is_mirrored(str(shown[name].view), str(shown[other].view))) is not None
        ]
        if found:
            _, other, flipped = max(found)
            own = aspects[name, part]
            result[name, part], residual = met(own, aspects[other, partner[part]], flipped, params)
            residuals.append(residual)
    return result, residuals


def met(own: Aspect, other: Aspect, flipped: bool, params: Registration) -> tuple[Aspect, float]:
    """An aspect with the mean of its own thickness and another's, if they lie well over each other; what is left."""
    surface = AspectSurface.of(*own.surface())
    vertices, faces = other.surface()
    partner = AspectSurface.of(vertices * [-1, 1, 1], faces[:, ::-1]) if flipped else AspectSurface.of(vertices, faces)
    found = register(surface, partner, params)
    if found.residual > MOST_RESIDUAL:
        return own, found.residual
    change = (surface.thickness(partner, found.transform) - surface.heights) / 2
    return corrected(own, surface, change), found.residual
