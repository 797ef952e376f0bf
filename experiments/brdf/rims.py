"""What the judge of rims should learn from, and how firmly: judges of several lessons on scenes of another kind.

They are the meshes and sheets of `development` and generated surfaces, all in measured materials under real probes,
each bare and painted. The lessons, as brdf-train gives them, differ in the maps that their scenes are seen through.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from experiments.brdf import development, painted
from experiments.brdf.scenes import Case
from experiments.kit.tables import write_table
from ipcli.io.files import atomic
from ipcli.models.brdf import rim, training
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.parameters import LibraryLearning
from ipcli.models.brdf.rim import Judge
from ipcli.models.brdf.solid import pictured
from ipcli.models.brdf.training import RimLesson
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import page, section, table
from ipcli.rng import stream

RIDGES = (40.0, 120.0, 360.0)
SHEETS, GENERATED = 30, 60


@dataclass(frozen=True)
class Judged:
    """How a judge did on scenes of one kind."""

    lesson: str
    ridge: float
    kind: str
    scenes: int
    right: float  # share on the right side of 1/2
    brier: float  # mean square of (posterior - label)


def measured(data: Path, shelf: Library, quick: bool) -> list[Judged]:
    """Every lesson at every ridge on every kind of scene."""
    params = replace(LibraryLearning(), scenes=60) if quick else LibraryLearning()
    found, asked = [], examined(_quick(shelf) if quick else _cases(data), params)
    for name, lesson in lessons(shelf, params).items():
        for ridge in RIDGES:
            judge = rim.learn(lesson.features, lesson.labels, ridge)
            found += [judged(judge, name, ridge, kind, scenes) for kind, scenes in asked.items()]
    return found


def judged(judge: Judge, lesson: str, ridge: float, kind: str, scenes: RimLesson) -> Judged:
    """A judge's figures on scenes whose labels are known."""
    p = judge.sheet(scenes.features)
    right, brier = ((p > 0.5) == (scenes.labels > 0.5)).mean(), ((p - scenes.labels) ** 2).mean()
    return Judged(lesson, ridge, kind, len(p), float(right), float(brier))


def lessons(shelf: Library, params: LibraryLearning) -> dict[str, RimLesson]:
    """The scenes of brdf-train through plain materials, as it does, those of the list, and both in turn."""
    kinds = {"plain": training.plain_charts(training.lights({}, params, 0), 0), "list": shelf.charts}
    made = {name: training.rim_lesson(charts, params, 0, range(params.scenes)) for name, charts in kinds.items()}
    odd = np.arange(params.scenes) % 2 == 1
    features = np.where(odd[:, None], made["list"].features, made["plain"].features)
    return made | {"in turn": RimLesson(features, made["plain"].labels)}


def examined(cases: Iterable[Case], params: LibraryLearning) -> dict[str, RimLesson]:
    """Features and labels of pictures by group, and of the same under paint."""
    found: dict[str, list[tuple[np.ndarray, float]]] = {}
    for number_, case in enumerate(cases):
        label = float(rim.better_as_sheet(case.mask, case.normals, params.relief))
        rng = stream(13, "rims", str(number_))
        over = painted.painted(case.colour, case.mask, painted.PAINTS[number_ % len(painted.PAINTS)], rng)
        for group, colour in ((case.group, case.colour), (f"{case.group}, painted", over)):
            found.setdefault(group, []).append((rim.features(pictured(colour, case.mask, params.grid)), label))
    return {
        group: RimLesson(np.array([f for f, _ in rows]), np.array([y for _, y in rows]))
        for group, rows in found.items()
    }


def _cases(data: Path) -> Iterator[Case]:
    yield from development.cases(data, sheets=SHEETS)
    yield from development.generated_cases(data, GENERATED)


def _quick(shelf: Library) -> Iterator[Case]:
    """Generated surfaces through the library's own maps: no data."""
    for number_ in range(12):
        taken = generated.scene(generated.surface(rng := stream(13, "rims", f"quick {number_}"), 96), shelf.charts, rng)
        made = taken.surface
        yield Case(f"{made.name} {number_}", "generated", taken.picture, made.mask, made.normals, made.height)


def write(folder: Path, found: list[Judged]) -> None:
    """CSV, JSON and page."""
    write_table(folder / "rims.csv", [asdict(one) for one in found], study="rims")
    kinds = {one.kind: one.scenes for one in found}
    rows = []
    for lesson, ridge in dict.fromkeys((one.lesson, one.ridge) for one in found):
        mine = {one.kind: one for one in found if (one.lesson, one.ridge) == (lesson, ridge)}
        cells = (f"{number(mine[kind].brier)} ({100 * mine[kind].right:.0f} %)" for kind in kinds)
        rows.append((lesson, number(ridge), *cells))
        print("  ".join(rows[-1]))
    heads = ("Lesson", "ridge", *(f"{kind} ({count})" for kind, count in kinds.items()))
    lead = "Mean square of the posterior's error; in brackets how many are on the right side of one half."
    verdict = "What the judge of rims should learn from, asked on scenes in measured materials under real probes."
    part = section("Judges", table(heads, rows), lead=lead)
    atomic.write_text(folder / "index.html", page("Is it a rim or a cut edge", "experiments/brdf", verdict, part))
