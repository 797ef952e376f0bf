"""What a library learns: maps of each material under all lights, the judge of rims and the classifier of materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf import material, rim
from ipcli.models.brdf.light import Light, key_and_fill, probe
from ipcli.models.brdf.parameters import Learning
from ipcli.models.brdf.scenes import photograph, scene, surface
from ipcli.models.brdf.solid import pictured
from ipcli.rng import stream


@dataclass(frozen=True, eq=False)
class Lights:
    """All lights of a library, in order: each probe at every heading, then the generated ones."""

    lights: list[Light]
    probe: np.ndarray  # (k,) index into `names`
    heading: np.ndarray  # (k,) radians
    names: tuple[str, ...]


def lights(probes: Mapping[str, np.ndarray], params: Learning, seed: int) -> Lights:
    """Lights of equirectangular probes (h, 2 h, 3) by name, and studio lights drawn from the seed."""
    turns = np.arange(params.headings) * 2 * np.pi / params.headings
    made, index, heading = [], [], []
    for number, image in enumerate(probes.values()):
        for turn in turns:
            made.append(probe(image, float(turn)))
            index.append(number)
            heading.append(float(turn))
    for number in range(params.lights):
        made.append(key_and_fill(stream(seed, "light", f"studio {number}")))
        index.append(len(probes) + number)
        heading.append(0.0)
    names = (*probes, *(f"studio {number}" for number in range(params.lights)))
    return Lights(made, np.array(index), np.array(heading), tuple(names))


@dataclass(frozen=True, eq=False)
class Lesson:
    """Features (n, f) of generated scenes with their labels (n,): 1 where the flattened balloon serves better."""

    features: np.ndarray
    labels: np.ndarray


def rim_lesson(
    charts: Sequence[np.ndarray], params: Learning, seed: int, tell: Callable[[float], None] = lambda share: None
) -> Lesson:
    """Scenes, half of them sheets, each through a random map; each scene has a random stream of its own."""
    rows, labels = [], []
    for number in range(params.scenes):
        rng = stream(seed, "rim", str(number))
        made = surface(rng, params.side)
        taken = scene(made, charts, rng)
        rows.append(rim.features(pictured(taken.picture, made.mask, params.grid)))
        labels.append(rim.better_as_sheet(made, params.relief))
        tell((number + 1) / params.scenes)
    return Lesson(np.array(rows), np.array(labels, float))


@dataclass(frozen=True, eq=False)
class Pictures:
    """Statistics (n, f) of generated pictures, and the material, the surface and the probe (n,) of each."""

    statistics: np.ndarray
    material: np.ndarray
    surface: np.ndarray
    probe: np.ndarray


def material_lesson(
    charts: np.ndarray, of_material: np.ndarray, of_probe: np.ndarray, params: Learning, seed: int, tell: Callable[[float], None] = lambda share: None
) -> Pictures:
    """Every generated surface pictured in every material, each under a random light of its own; a quarter are sheets."""
    count = int(of_material.max()) + 1
    rows, materials, surfaces, probes = [], [], [], []
    for number in range(params.pictures):
        rng = stream(seed, "material", str(number))
        made = surface(rng, params.side, sheets=0.25)
        for index in range(count):
            chart = int(rng.choice(np.flatnonzero(of_material == index)))
            picture = photograph(made, charts[chart], rng)
            rows.append(material.statistics(pictured(picture, made.mask, params.grid)))
            materials.append(index)
            surfaces.append(number)
            probes.append(of_probe[chart])
        tell((number + 1) / params.pictures)
    return Pictures(np.array(rows), np.array(materials), np.array(surfaces), np.array(probes))
