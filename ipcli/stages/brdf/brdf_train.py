"""brdf-train: materials and light probes -> a library of reflectance maps and of what was learnt on generated scenes
(chapter 7).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.executor import map_items
from ipcli.io.files import h5
from ipcli.io.materials import probes
from ipcli.models.brdf import training
from ipcli.models.brdf.reflectance import charts
from ipcli.params import Run
from ipcli.progress import Progress, portion, silent
from ipcli.stages.brdf.materials import Listed, brdf, is_metal, read
from ipcli.stages.brdf.parameters import BrdfTrain
from ipcli.stages.kit.artefact import Job, Outcome, make_resumable
from ipcli.stages.kit.checkpoint import Checkpoint
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import Figure, of_result


def run(source: Path, output: Path, params: BrdfTrain, run: Run, progress: Progress = silent) -> Outcome:
    """Write the library and beside it a page (.html). A run that was killed goes on with the materials and lessons
    that are left, to the same bytes.
    """
    listed = read(source)
    job = Job(output, "brdf-library", "brdf-train", params, listed.inputs(source), page(output, "brdf-library"))
    return make_resumable(job, lambda work: library(listed, params, run, work, progress), run)


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of a library."""
    wanted = ("materials", "probes", "chart_material", "rim_scenes", "material_accuracy", "rim_accuracy")
    arrays = h5.read(output, "brdf-library", lambda name: name in wanted).arrays
    rim, (material, metal) = arrays["rim_accuracy"], arrays["material_accuracy"]
    told = f"rim {rim:.0%}, material {material:.0%}, metal or not {metal:.0%} (held out)"
    return {
        "materials": len(arrays["materials"]),
        "lights": len(arrays["probes"]),
        "maps": len(arrays["chart_material"]),
        "scenes of the judge": int(arrays["rim_scenes"]),
        "told right": Figure({"rim": rim, "material": material, "metal or not": metal}, told),
    }


def library(listed: Listed, params: BrdfTrain, run: Run, work: Checkpoint, progress: Progress) -> dict[str, np.ndarray]:
    """The arrays of the `brdf-library` artefact; the maps of each material are one item of the executor."""
    names = list(listed.materials)
    one = partial(maps_of, listed=listed, params=params, seed=run.seed, work=work)
    made = map_items(one, names, run.executor, portion(progress, 0.0, 0.3))
    metals = np.array([is_metal(entry) for entry in listed.materials.values()])
    seen = np.concatenate([made[name] for name in names])
    known = lights_of(listed, params, run.seed)
    return training.learn(
        seen,
        names,
        metals,
        known,
        params.learning,
        run.seed,
        portion(progress, 0.3, 1.0),
        lambda name, build: kept(work, name, build),
    )


def lights_of(listed: Listed, params: BrdfTrain, seed: int) -> training.Lights:
    """The lights of the list and the generated ones."""
    return training.lights({name: probes.read(path) for name, path in listed.probes.items()}, params.learning, seed)


def maps_of(name: str, *, listed: Listed, params: BrdfTrain, seed: int, work: Checkpoint) -> np.ndarray:
    """Charts (k, s, s, 3) of one material under all lights, those of a killed run if they are there."""

    def build() -> dict[str, np.ndarray]:
        known = lights_of(listed, params, seed)
        return {"charts": np.maximum(charts(brdf(listed.materials[name]), known.lights), 0).astype(np.float32)}

    return kept(work, f"maps of {name}", build)["charts"]


def kept(work: Checkpoint, name: str, build: training.Build) -> dict[str, np.ndarray]:
    """What a run that was killed has left under this name, or what `build` makes, which is then kept."""
    found = work.load(name)
    if found is None:
        found = build()
        work.save(name, found)
    return found
