"""What a library learns: maps of each material under all lights, the judge of rims and the classifier of materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.models.brdf import material, rim
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.light import Light, key_and_fill, probe
from ipcli.models.brdf.parameters import LibraryLearning
from ipcli.models.brdf.scenes import photograph, scene, surface
from ipcli.models.brdf.solid import pictured
from ipcli.progress import Progress, silent
from ipcli.rng import stream


@dataclass(frozen=True, eq=False)
class Lights:
    """All lights of a library, in order: each probe at every heading, then the generated ones."""

    lights: list[Light]
    probe: np.ndarray  # (k,) index into `names`
    heading: np.ndarray  # (k,) radians
    names: tuple[str, ...]


def lights(probes: Mapping[str, np.ndarray], params: LibraryLearning, seed: int) -> Lights:
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
class RimLesson:
    """Features (n, f) of generated scenes with their labels (n,): 1 where the flattened balloon serves better."""

    features: np.ndarray
    labels: np.ndarray


def rim_lesson(charts: np.ndarray, params: LibraryLearning, seed: int, tell: Progress = silent) -> RimLesson:
    """Scenes, half of them sheets, each through a random map; each scene has a random stream of its own."""
    rows, labels = [], []
    for number in range(params.scenes):
        rng = stream(seed, "rim", str(number))
        made = surface(rng, params.side)
        taken = scene(made, charts, rng)
        rows.append(rim.features(pictured(taken.picture, made.mask, params.grid)))
        labels.append(rim.better_as_sheet(made, params.relief))
        tell((number + 1) / params.scenes, "rims")
    return RimLesson(np.array(rows), np.array(labels, float))


@dataclass(frozen=True, eq=False)
class MaterialLesson:
    """Statistics (n, f) of generated pictures, and the material, the surface and the probe (n,) of each."""

    statistics: np.ndarray
    material: np.ndarray
    surface: np.ndarray
    probe: np.ndarray


def material_lesson(
    charts: np.ndarray,
    of_material: np.ndarray,
    of_probe: np.ndarray,
    params: LibraryLearning,
    seed: int,
    tell: Progress = silent,
) -> MaterialLesson:
    """Every generated surface pictured in every material, each under a random light of its own; a quarter are
    sheets.
    """
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
        tell((number + 1) / params.pictures, "materials")
    return MaterialLesson(np.array(rows), np.array(materials), np.array(surfaces), np.array(probes))


def learn(
    charts: np.ndarray,
    names: Sequence[str],
    metals: np.ndarray,
    known: Lights,
    params: LibraryLearning,
    seed: int,
    tell: Progress = silent,
) -> dict[str, np.ndarray]:
    """The whole library as arrays, from the charts (b k, s, s, 3) of b materials under k lights; metals (b,) bool."""
    count = len(known.lights)
    of_material, of_probe = np.repeat(np.arange(len(names)), count), np.tile(known.probe, len(names))
    outlines = rim_lesson(charts, params, seed, lambda share, what: tell(0.6 * share, what))
    shown = material_lesson(
        charts, of_material, of_probe, params, seed, lambda share, what: tell(0.6 + 0.4 * share, what)
    )
    judge = rim.learn(outlines.features, outlines.labels)
    classifier = material.learn(shown.statistics, shown.material, len(names))
    shelf = Library(charts, of_material, of_probe, tuple(names), known.names, judge, classifier)
    told = material.accuracy(shown.statistics, shown.material, shown.surface, shown.probe, metals)
    return shelf.arrays() | {
        "chart_heading": np.tile(known.heading, len(names)),
        "is_metal": metals.astype(np.uint8),
        "material_accuracy": np.array(told),
        "rim_accuracy": np.array(rim.accuracy(outlines.features, outlines.labels)),
        "rim_scenes": np.array(len(outlines.labels), np.int64),
    }
