"""The page of the experiments defaults and defaults-kitti: what settings of fuse-depth rest on, each by itself beside
its neighbours, on the development scenes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.kit.arguments import Arguments
from experiments.kit.run import Findings, page_of, quick_lead
from ipcli.measurements.accuracy import mean_over_scenes
from ipcli.models.fusion.fuse import Fused, fuse_unfilled, with_holes_filled
from ipcli.models.fusion.parameters import Fusion, Holes
from ipcli.models.fusion.scenes import EstimatedMap, Scene
from ipcli.params import find_config, resolve
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, section, table
from ipcli.stages.fusion.parameters import FuseDepth
from ipcli.stages.fusion.sources import open_scene

QUICK = 2  # values of a setting that a look takes
ROUGHLY = (
    "fusion.solver.tolerance=0.01",
    "fusion.solver.iterations=100",
)  # as the grids of lambda are, in a fifth of the time
REFERENCES = {"defaults-kitti": "10_left"}


@dataclass(frozen=True)
class Choice:
    """A configuration, the measures that its settings are judged by, and the values that are tried of each."""

    title: str
    config: str | None
    measures: tuple[str, ...]
    tried: Mapping[str, tuple[float, ...]]
    solver: tuple[str, ...] = ()  # settings of it that hold for all


CHOICES = {
    "defaults": Choice(
        "The defaults of fuse-depth",
        None,
        ("RMSE", "MAE", "N-MAE rad"),
        {
            "fusion.edges.gain": (0.0, 1.0, 2.0, 4.0),
            "fusion.edges.width": (0.1, 0.3, 1.0),
            "fusion.regulariser.alpha0": (2.0, 3.0, 4.5),
            "fusion.confidence.shape": (1.5, 11.0, 21.0, 41.0),
            "fusion.holes.believed": (3.0, 5.0, 8.0),
            "fusion.holes.reach": (50.0, 100.0, 200.0),
        },
        ROUGHLY,
    ),
    "defaults-kitti": Choice(
        "The configuration kitti of fuse-depth",
        "fuse-depth/kitti",
        ("out-3 %", "D-avg px"),
        {
            "fusion.edges.image": (1.5, 3.0, 6.0),
            "fusion.edges.gain": (0.0, 1.0, 2.0),
            "fusion.regulariser.alpha1": (2.0, 4.0, 8.0),
            "fusion.regulariser.alpha0": (8.0, 16.0, 32.0),
            "fusion.holes.believed": (3.0, 5.0, 8.0),
            "fusion.holes.reach": (50.0, 100.0, 200.0),
        },
    ),
}


def rows_of(scenes: Sequence[Scene], choice: Choice, quick: bool) -> list[dict[str, object]]:
    """A row for each setting at each value, all others as the configuration has them: its measures over the scenes, and
    on how many of them each is better than at the value that is shipped.
    """
    config = find_config(Path(choice.config), "fuse-depth") if choice.config else None
    shipped = resolve(FuseDepth, config=config, sets=choice.solver)
    tried = {
        (key, value): resolve(FuseDepth, config=config, sets=[*choice.solver, f"{key}={value!r}"])
        for key, values in choice.tried.items()
        for value in [
            *[v for v in values if v != _value(shipped, key)][: QUICK - 1 if quick else None],
            _value(shipped, key),
        ]
    }
    found = [measures_of(scene, [shipped, *tried.values()], choice.measures) for scene in scenes]
    rows: list[dict[str, object]] = []
    for key, value in sorted(tried, key=lambda at: (list(choice.tried).index(at[0]), at[1])):
        own = np.stack([of_scene[tried[key, value]] for of_scene in found])
        better = (own < np.stack([of_scene[shipped] for of_scene in found])).sum(axis=0)
        row: dict[str, object] = {"setting": key, "value": value, "shipped": value == _value(shipped, key)}
        for measure, mean, count in zip(choice.measures, mean_over_scenes(own, choice.measures), better, strict=True):
            row |= {measure: float(mean), f"{measure} better": int(count)}
        rows.append(row)
    return rows


def measures_of(scene: Scene, settings: Sequence[FuseDepth], measures: Sequence[str]) -> dict[FuseDepth, np.ndarray]:
    """The measures of the fused map of a scene at each of these settings, which are fused once each; the reach of holes
    counts after the fusion alone.
    """
    unfilled: dict[Fusion, Fused] = {}
    found: dict[FuseDepth, np.ndarray] = {}
    for params in settings:
        if params in found:
            continue
        fusion = params.fusion
        fused = replace(fusion, holes=replace(fusion.holes, reach=Holes.reach))
        if fused not in unfilled:
            unfilled[fused] = fuse_unfilled(scene.views, scene.reference, fused, inverse=scene.inverse)
        filled = with_holes_filled(unfilled[fused], scene.reference, fusion, inverse=scene.inverse)
        columns, rows = scene.errors({"fused": EstimatedMap.of(filled)})
        found[params] = rows[0][[columns.index(measure) for measure in measures]]
        print(scene.reference.name, len(found), *found[params].round(4), flush=True)
    return found


def _value(params: object, key: str) -> float:
    for name in key.split("."):
        params = getattr(params, name)
    assert isinstance(params, float)
    return params


def sections(rows: Sequence[Mapping[str, object]], choice: Choice) -> list[Markup]:
    """A table for each setting: how far each measure is from that of the shipped value."""
    parts = []
    for key in choice.tried:
        mine = [row for row in rows if row["setting"] == key]
        own = next(row for row in mine if row["shipped"])
        lines = [
            (
                number(float(str(row["value"]))) + (" (shipped)" if row["shipped"] else ""),
                *(told(row, own, measure) for measure in choice.measures),
            )
            for row in mine
        ]
        parts.append(section(key, table(("Value", *choice.measures), lines)))
    return parts


def told(row: Mapping[str, object], own: Mapping[str, object], measure: str) -> str:
    """A mean, how far it is from that of the shipped value, and on how many scenes it is better."""
    figure = number(_figure(row, measure))
    if row["shipped"]:
        return figure
    change = _figure(row, measure) / _figure(own, measure) - 1
    return f"{figure} ({'+' if change >= 0 else '−'}{percent(abs(change))}, better on {row[f'{measure} better']})"


def _figure(row: Mapping[str, object], measure: str) -> float:
    return float(str(row[measure]))


def make(given: Arguments) -> Findings:
    """Try all values on all scenes: the page and the table of what they give."""
    choice = CHOICES[given.name]
    scenes = [open_scene(path, REFERENCES.get(given.name), "auto") for path in given.files]
    rows = rows_of(scenes, choice, given.quick)
    lead = (
        f"Each setting by itself, all others as they are shipped, on {len(scenes)} development scenes; means over the "
        "scenes, and in brackets how far that is from the shipped value's and on how many scenes it is better. None of "
        "them is in a table of results."
    )
    lead += " All maps are solved roughly, as those of the grids of lambda are." * bool(choice.solver)
    lead = (quick_lead("small generated scenes") if given.quick else "") + lead
    return Findings(page_of("fusion", choice.title, lead, *sections(rows, choice)), rows, {"title": choice.title})
