"""model-animal: images with part masks -> one closed surface with named parts (thesis chapter 6).

Three steps, each an artefact of its own in X.steps/, so that a run that was killed, or changes a late parameter, does
not begin anew: aspects (6.3.1), components with their cameras (6.3.2, 6.4), assembly.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import ParameterError
from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.voxels import VoxelGrid
from ipcli.io.files import h5
from ipcli.io.parts import project
from ipcli.io.parts.project import Project
from ipcli.measurements.part_images import PartImage, folded, oddities, told
from ipcli.models.animal import whole
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.doubts import beforehand, doubts
from ipcli.models.animal.merging import Overlay, alike, merged
from ipcli.models.animal.parameters import Inflation, Modelling, Registration, Volume
from ipcli.models.animal.placing import placed
from ipcli.models.animal.reposed import reposed, tells_shape
from ipcli.params import Run
from ipcli.progress import Progress, portion, silent
from ipcli.stages.animal.output import side_files
from ipcli.stages.animal.parameters import ModelAnimal
from ipcli.stages.kit import outputs
from ipcli.stages.kit.artefact import Job, Outcome, make

log = logging.getLogger(__name__)

Arrays = dict[str, np.ndarray]
REGISTRATIONS = "registrations/"
CLIP = 8.0  # voxels beyond which fields are not kept


@dataclass(frozen=True)
class Lifting:
    """Parameters of the first step."""

    inflation: Inflation
    registration: Registration
    other_pose: str


@dataclass(frozen=True)
class Placing:
    """Parameters of the second step."""

    volume: Volume
    other_pose: str


def run(source: Path, output: Path, params: ModelAnimal, run: Run, progress: Progress = silent) -> tuple[Path, Outcome]:
    """Write X.h5, the model as X.glb (or .ply, .obj, .stl after the suffix of `output`) and pages beside it.

    Returns the last artefact and what became of it. Raises FormatError for the project and its masks, NoSolution when
    the silhouettes have nothing in common.
    """
    artefact = output.with_suffix(".h5")
    beside = side_files(output, params, project.read(source).tree if source.is_file() else None)
    animal = project.read(source)
    for line in folded(oddities(animal.images, animal.tree)):  # the page has the harmless ones too
        log.warning("%s: %s", source.name, line)
    for line in beforehand([image for image in animal.images if image.is_reference]):
        log.warning("%s: %s", source.name, line)
    steps = artefact.with_suffix(".steps")
    aspects, components = steps / "aspects.h5", steps / "components.h5"
    job = Job(artefact, "animal-model", "model-animal", params, (*animal.files, aspects, components), beside)
    outputs.check_names(artefact, (*beside, outputs.run_record_path(artefact)), animal.files)
    job.standing()  # refuses a name that is taken before any step is run
    modelling = params.modelling
    lifting = Lifting(modelling.inflation, modelling.registration, modelling.other_pose)
    done = _make(Job(aspects, "animal-aspects", "model-animal", lifting, animal.files),
                 partial(aspects_artefact, animal, params.modelling, portion(progress, 0.0, 0.3)), run)  # fmt: skip
    if params.stop_after == "aspects":
        return aspects, done
    placing = Placing(params.modelling.volume, params.modelling.other_pose)
    done = _make(Job(components, "animal-components", "model-animal", placing, (*animal.files, aspects)),
                 partial(components_artefact, animal, aspects, params.modelling, portion(progress, 0.3, 0.7)),
                 run)  # fmt: skip
    if params.stop_after == "components":
        return components, done
    build = partial(model_artefact, animal, aspects, components, params.modelling, portion(progress, 0.7, 1.0))
    return artefact, _make(job, build, run)


def _make(job: Job, build: Callable[[], Arrays], run: Run) -> Outcome:
    if run.dry_run and any(not path.exists() for path in job.inputs):
        return Outcome.WOULD_RUN  # a step before this one would run first
    return make(job, build, run)


def _tree(animal: Project) -> Arrays:
    return {"parts": np.array(animal.tree.names), "parents": np.array(animal.tree.parents, np.int16)}


def aspects_artefact(animal: Project, params: Modelling, tell: Progress) -> Arrays:
    """The arrays of `animal-aspects`."""
    arrays = _tree(animal) | {"load": np.array(params.inflation.load)}
    lifted = lift_all(animal.images, animal.tree, params.inflation, portion(tell, 0.0, 0.6))
    pairs = alike(animal.images, lifted, animal.matches, params.other_pose)
    lifted, overlays = merged(lifted, pairs, animal.matches, params.registration, portion(tell, 0.6, 1.0))
    for number, overlay in enumerate(overlays):
        arrays |= _registration(f"{REGISTRATIONS}{number:04d}", overlay)
    areas = {image.name: image for image in animal.images}
    for number, ((name, part), aspect) in enumerate(lifted.items()):
        rows, columns = np.nonzero(aspect.mask)
        top, left = int(rows.min()), int(columns.min())
        own = aspect.picture[top : rows.max() + 1, left : columns.max() + 1]
        arrays |= {
            f"aspects/{number:04d}/image": np.array(name),
            f"aspects/{number:04d}/part": np.array(part, np.int16),
            f"aspects/{number:04d}/heights": np.ascontiguousarray(own),
            f"aspects/{number:04d}/corner": np.array([left, top], np.int32),
            f"aspects/{number:04d}/area": np.array(areas[name].mask(part).sum(), np.int64),
        }
    return arrays


def _registration(stem: str, overlay: Overlay) -> Arrays:
    return {
        f"{stem}/part": np.array(overlay.part, np.int16),
        f"{stem}/images": np.array(overlay.images),
        f"{stem}/transform": overlay.transform,
        f"{stem}/residual": np.array(overlay.residual),
        f"{stem}/is_used": np.array(overlay.is_used),
        f"{stem}/heights": overlay.heights.astype(np.float32),
        f"{stem}/before": overlay.before.astype(np.float32),
        f"{stem}/after": overlay.after.astype(np.float32),
    }


def read_heights(path: Path, images: Mapping[str, PartImage]) -> dict[tuple[str, int], np.ndarray]:
    """Half thickness (h, w) in pixels by image and part, from an `animal-aspects` artefact."""
    arrays = h5.read(path, "animal-aspects").arrays
    heights = {}
    for key in (name for name in arrays if name.startswith("aspects/") and name.endswith("/heights")):
        stem = key.removesuffix("/heights")
        name, own = str(arrays[f"{stem}/image"]), arrays[key]
        left, top = arrays[f"{stem}/corner"]
        whole_picture = np.zeros(images[name].labels.shape, np.float32)
        whole_picture[top : top + own.shape[0], left : left + own.shape[1]] = own
        heights[name, int(arrays[f"{stem}/part"])] = whole_picture
    return heights


def components_artefact(animal: Project, aspects: Path, params: Modelling, tell: Progress) -> Arrays:
    """The arrays of `animal-components`."""
    images = [image for image in animal.images if image.is_reference]
    heights = read_heights(aspects, {image.name: image for image in animal.images})
    tell(0.1, "cameras")
    cameras = placed(images, animal.tree, params)
    tell(0.3, "carving and rounding")
    fields, shots, grid = whole.parts_of(images, cameras, animal.tree, heights, params.volume)
    others = [image for image in animal.images if not image.is_reference]
    bent: Arrays = {}
    if others and params.other_pose == "bend" and not tells_shape(others):
        if not any(name.startswith(REGISTRATIONS) for name in h5.read(aspects, "animal-aspects").arrays):
            log.warning(
                '%s: pose = "other" gives shape only with names of views along two lines, left and top say, or with a '
                "view that the reference pose has too",
                animal.name,
            )
    elif others and params.other_pose == "bend":
        fields, overlap = reposed(others, shots, grid, fields, animal.tree, heights, params, portion(tell, 0.4, 1.0))
        bent = {"bent_overlap": np.array(overlap)}
    return (
        _tree(animal)
        | {
            "origin": grid.origin.astype(np.float64),
            "spacing": np.array(grid.spacing),
            "fields": np.clip(fields, -CLIP, CLIP).astype(np.float32),
        }
        | _cameras(images, cameras)
        | bent
    )


def _cameras(images: list[PartImage], cameras: list[Orthographic]) -> Arrays:
    return {
        "images": np.array([image.name for image in images]),
        "rotations": np.array([camera.rotation for camera in cameras]),
        "scales": np.array([camera.scale for camera in cameras]),
        "shifts": np.array([camera.shift for camera in cameras]),
    }


def model_artefact(animal: Project, aspects: Path, components: Path, params: Modelling, tell: Progress) -> Arrays:
    """The arrays of `animal-model`, its longest side as long as the project says."""
    images = [image for image in animal.images if image.is_reference]
    arrays = h5.read(components, "animal-components").arrays
    grid = VoxelGrid(arrays["origin"], float(arrays["spacing"]), arrays["fields"].shape[1:])
    rows = zip(arrays["rotations"], arrays["scales"].tolist(), arrays["shifts"], strict=True)
    cameras = [Orthographic(rotation, scale, shift) for rotation, scale, shift in rows]
    shots = whole.shots_of(images, cameras, grid)
    tell(0.1, "merging and rounding")
    surface = whole.surface(list(arrays["fields"]), shots, grid, params.volume, is_drawn="bent_overlap" in arrays)
    surface, cameras = whole.scaled(surface, cameras, animal.size)
    tell(0.7, "looking at it")
    shown, pictures = _looked_at(surface, images, cameras, len(animal.tree))
    bent = float(arrays["bent_overlap"]) if "bent_overlap" in arrays else None
    doubtful = doubts(images, cameras, animal.tree, shown["overlaps"].tolist(), surface.face_part, bent)
    for line in doubtful:
        log.warning("%s: %s", animal.name, line)
    bodies = {
        f"bodies/{part:03d}/{key}": value
        for part, (vertices, faces) in surface.parts.items()
        for key, value in (("part", np.array(part, np.int16)), ("vertices", vertices), ("faces", faces))
    }
    return (
        _tree(animal)
        | {
            "name": np.array(animal.name),
            "vertices": surface.vertices,
            "faces": surface.faces,
            "face_part": surface.face_part,
            "seen_by": whole.seen_by(surface, images, cameras),
            "views": np.array([image.view or "" for image in images]),
            "doubts": np.array([*beforehand(images), *doubtful], dtype=np.str_).reshape(-1),
            "warnings": np.array(told(oddities(animal.images, animal.tree)), dtype=np.str_).reshape(-1),
        }
        | _cameras(images, cameras)
        | shown
        | bodies
        | pictures
        | _registrations(aspects)
    )


def _registrations(aspects: Path) -> Arrays:
    arrays = h5.read(aspects, "animal-aspects").arrays
    return {name: values for name, values in arrays.items() if name.startswith(REGISTRATIONS)}


def _looked_at(
    surface: whole.PartedSurface, images: list[PartImage], cameras: list[Orthographic], parts: int
) -> tuple[Arrays, Arrays]:
    """How well the model fits each image, and the images beside renderings of it."""
    from ipcli.geometry.part_masks import render

    overlaps, each = [], []
    pictures: Arrays = {}
    for number, (image, camera) in enumerate(zip(images, cameras, strict=True)):
        vertices = surface.vertices.astype(np.float64)
        rendered, _ = render(vertices, surface.faces, surface.face_part + 1, camera, image.labels.shape)
        total, by_part = whole.overlap(image.labels, rendered, parts)
        overlaps.append(total)
        each.append(by_part)
        stem = f"pictures/{number:03d}"
        pictures |= {f"{stem}/labels": image.labels, f"{stem}/rendered": rendered}
        if image.picture is not None:
            pictures[f"{stem}/picture"] = image.picture
    return {"overlaps": np.array(overlaps), "part_overlaps": np.array(each)}, pictures


def facts(path: Path) -> dict[str, Any]:
    """What a person wants to know of a model."""
    arrays = h5.read(path, "animal-model").arrays
    fits = dict(zip(arrays["images"].tolist(), arrays["overlaps"].round(3).tolist(), strict=True))
    return {
        "parts": len(np.unique(arrays["face_part"])),
        "faces": len(arrays["faces"]),
        "overlap": fits,
        "unseen": round(float((arrays["seen_by"] == 0).mean()), 3),
    }


def check_suffix(output: Path) -> None:
    """Raise ParameterError for an output that is no model."""
    from ipcli.io.meshes.assembly import SUFFIXES

    if output.suffix not in (*SUFFIXES, ".h5"):
        raise ParameterError(f"{output}: a model is written as {', '.join(SUFFIXES)}; got '{output.suffix}'")
