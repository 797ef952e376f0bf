"""brdf-train: materials and light probes -> a library of reflectance maps and of what was learnt on generated scenes (chapter 7)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ipcli.params import Run
from ipcli.stages.brdf.parameters import TrainParams

if TYPE_CHECKING:
    import numpy as np

    from ipcli.stages.artefact import Outcome
    from ipcli.stages.brdf.materials import Listed


def run(
    source: Path, output: Path, params: TrainParams, run: Run, progress: Callable[[float, str], None] = lambda share, what: None
) -> Outcome:
    """Write the library and beside it a page (.html)."""
    from ipcli.stages.artefact import Job, make
    from ipcli.stages.brdf.materials import read

    listed = read(source)
    beside = {output.with_suffix(".html"): write_report}
    job = Job(output, "brdf-library", "brdf-train", params, listed.inputs(source), beside)
    return make(job, lambda: library(listed, params, run, progress), run)


def library(listed: Listed, params: TrainParams, run: Run, progress: Callable[[float, str], None]) -> dict[str, np.ndarray]:
    """The arrays of the `brdf-library` artefact; the maps of each material are one item of the executor."""
    import numpy as np

    from ipcli.executor import map_items
    from ipcli.models.brdf import material, rim
    from ipcli.models.brdf.library import Library
    from ipcli.models.brdf.training import material_lesson, rim_lesson
    from ipcli.stages.brdf.materials import is_metal

    names = list(listed.materials)
    one = partial(maps_of, listed=listed, params=params, seed=run.seed)
    made = map_items(one, names, run.executor, lambda share, what: progress(0.3 * share, what))
    known = lights_of(listed, params, run.seed)
    charts = np.concatenate([made[name] for name in names])
    count = len(known.lights)
    of_material, of_probe = np.repeat(np.arange(len(names)), count), np.tile(known.probe, len(names))
    lesson = rim_lesson(charts, params.learning, run.seed, lambda share: progress(0.3 + 0.4 * share, "rims"))
    shown = material_lesson(charts, of_material, of_probe, params.learning, run.seed, lambda share: progress(0.7 + 0.3 * share, "materials"))
    judge = rim.learn(lesson.features, lesson.labels)
    classifier = material.learn(shown.statistics, shown.material, len(names))
    metals = np.array([is_metal(entry) for entry in listed.materials.values()])
    told = material.accuracy(shown.statistics, shown.material, shown.surface, shown.probe, metals)
    shelf = Library(charts, of_material, of_probe, tuple(names), known.names, judge, classifier)
    return shelf.arrays() | {
        "chart_heading": np.tile(known.heading, len(names)),
        "is_metal": metals.astype(np.uint8),
        "material_accuracy": np.array(told),
        "rim_accuracy": np.float64(rim.accuracy(lesson.features, lesson.labels)),
        "rim_scenes": np.int64(len(lesson.labels)),
    }


def lights_of(listed: Listed, params: TrainParams, seed: int) -> Any:
    """The lights of the list and the generated ones."""
    from ipcli.io.materials import probes
    from ipcli.models.brdf.training import lights

    return lights({name: probes.read(path) for name, path in listed.probes.items()}, params.learning, seed)


def maps_of(name: str, *, listed: Listed, params: TrainParams, seed: int) -> np.ndarray:
    """Charts (k, s, s, 3) of one material under all lights."""
    import numpy as np

    from ipcli.models.brdf.reflectance import charts
    from ipcli.stages.brdf.materials import brdf

    known = lights_of(listed, params, seed)
    return np.maximum(charts(brdf(listed.materials[name]), known.lights), 0).astype(np.float32)


def write_report(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The page to look at."""
    from ipcli.io import atomic
    from ipcli.report.brdf import brdf_train

    atomic.write_text(path, brdf_train.page(arrays, provenance))
