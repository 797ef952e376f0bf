"""What a library learns: maps of each material under all lights, the judge of rims and the classifier of materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ipcli.models.brdf import material, rim
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.light import Light, key_and_fill, probe
from ipcli.models.brdf.materials import Brdf, Matte, Plastic
from ipcli.models.brdf.parameters import LibraryLearning
from ipcli.models.brdf.reflectance import charts
from ipcli.models.brdf.scenes import photograph, scene, surface
from ipcli.models.brdf.solid import pictured
from ipcli.progress import Progress, silent
from ipcli.rng import stream

Build = Callable[[], dict[str, np.ndarray]]
Keep = Callable[[str, Build], dict[str, np.ndarray]]
COATED = 3  # plastics beside the matte ground
PART = 50  # generated scenes or surfaces that are kept together when a run is killed


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


def plain_charts(known: Lights, seed: int) -> np.ndarray:
    """Colour charts (b k, s, s, 3) of what most things are made of: a matte ground, then coated ones, under b lights.

    The judge of rims learns from them, not from the materials of the list: of metals alone it learns that what light
    of low order explains is a sheet, and takes a paper cup for one.
    """
    rng = stream(seed, "plain", "coats")
    coated = [
        Plastic(tuple(map(float, rng.uniform(0.1, 0.8, 3))), 1.5, float(rng.uniform(0.15, 0.6))) for _ in range(COATED)
    ]
    brdfs: list[Brdf] = [Matte((0.7, 0.7, 0.7)), *coated]
    made = [charts(brdf, known.lights, coarse=17) for brdf in brdfs]
    return np.maximum(np.concatenate(made), 0).astype(np.float32)


@dataclass(frozen=True, eq=False)
class RimLesson:
    """Features (n, f) of generated scenes with their labels (n,): 1 where the flattened balloon serves better."""

    features: np.ndarray
    labels: np.ndarray


def rim_lesson(seen: np.ndarray, params: LibraryLearning, seed: int, numbers: range) -> RimLesson:
    """The scenes of these numbers, half of them sheets, each through a random map; each has a random stream of its
    own.
    """
    rows, labels = [], []
    for number in numbers:
        rng = stream(seed, "rim", str(number))
        made = surface(rng, params.side)
        taken = scene(made, seen, rng)
        rows.append(rim.features(pictured(taken.picture, made.mask, params.grid)))
        labels.append(rim.better_as_sheet(made.mask, made.normals, params.relief))
    return RimLesson(np.array(rows), np.array(labels, float))


@dataclass(frozen=True, eq=False)
class MaterialLesson:
    """Statistics (n, f) of generated pictures, and the material, the surface and the probe (n,) of each."""

    statistics: np.ndarray
    material: np.ndarray
    surface: np.ndarray
    probe: np.ndarray


def material_lesson(
    seen: np.ndarray,
    of_material: np.ndarray,
    of_probe: np.ndarray,
    params: LibraryLearning,
    seed: int,
    numbers: range,
) -> MaterialLesson:
    """The surfaces of these numbers pictured in every material, each under a random light of its own; a quarter are
    sheets.
    """
    rows, materials, surfaces, probes = [], [], [], []
    for number in numbers:
        rng = stream(seed, "material", str(number))
        made = surface(rng, params.side, sheets=0.25)
        for index in range(int(of_material.max()) + 1):
            chart = int(rng.choice(np.flatnonzero(of_material == index)))
            picture = photograph(made, seen[chart], rng)
            rows.append(material.statistics(pictured(picture, made.mask, params.grid)))
            materials.append(index)
            surfaces.append(number)
            probes.append(of_probe[chart])
    return MaterialLesson(np.array(rows), np.array(materials), np.array(surfaces), np.array(probes))


def _fields(lesson: Callable[[range], Any], numbers: range) -> dict[str, np.ndarray]:
    return dict(vars(lesson(numbers)))


def in_parts(
    count: int, name: str, lesson: Callable[[range], Any], keep: Keep, tell: Callable[[float], None]
) -> dict[str, np.ndarray]:
    """The fields of a lesson on `count` scenes, made and kept in parts."""
    parts = []
    for start in range(0, count, PART):
        numbers = range(start, min(start + PART, count))
        parts.append(keep(f"{name} {start}", partial(_fields, lesson, numbers)))
        tell(numbers.stop / count)
    return {field: np.concatenate([part[field] for part in parts]) for field in parts[0]}


def learn(
    seen: np.ndarray,
    names: Sequence[str],
    metals: np.ndarray,
    known: Lights,
    params: LibraryLearning,
    seed: int,
    tell: Progress = silent,
    keep: Keep = lambda name, build: build(),
) -> dict[str, np.ndarray]:
    """The library as arrays, from the charts `seen` (b k, s, s, 3) of b materials under k lights; metals (b,) bool.

    `keep(name, build)` gives what `build()` makes, or what it made before under that name.
    """
    count = len(known.lights)
    of_material, of_probe = np.repeat(np.arange(len(names)), count), np.tile(known.probe, len(names))
    plain = keep("plain maps", lambda: {"charts": plain_charts(known, seed)})["charts"]
    outlines = RimLesson(
        **in_parts(
            params.scenes,
            "rims",
            lambda numbers: rim_lesson(plain, params, seed, numbers),
            keep,
            lambda share: tell(0.6 * share, "rims"),
        )
    )
    shown = MaterialLesson(
        **in_parts(
            params.pictures,
            "materials",
            lambda numbers: material_lesson(seen, of_material, of_probe, params, seed, numbers),
            keep,
            lambda share: tell(0.6 + 0.4 * share, "materials"),
        )
    )
    judge = rim.learn(outlines.features, outlines.labels)
    classifier = material.learn(shown.statistics, shown.material, len(names))
    shelf = Library(seen, of_material, of_probe, tuple(names), known.names, judge, classifier)
    told = material.accuracy(shown.statistics, shown.material, shown.surface, shown.probe, metals)
    return shelf.arrays() | {
        "chart_heading": np.tile(known.heading, len(names)),
        "is_metal": metals.astype(np.uint8),
        "material_accuracy": np.array(told),
        "rim_accuracy": np.array(rim.accuracy(outlines.features, outlines.labels)),
        "rim_scenes": np.array(len(outlines.labels), np.int64),
    }
