"""brdf-model: one photograph and its mask -> the surface of the object, its light and material (thesis chapter 7)."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, NoSolution
from ipcli.geometry.relief import closed, front
from ipcli.io.files import h5, images, ply
from ipcli.io.materials import photographs
from ipcli.io.materials.photographs import Photograph
from ipcli.io.meshes import stl
from ipcli.models.brdf import evaluation
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.reconstruct import Reconstruction, baselines, integrated, reconstruct
from ipcli.models.brdf.rim import FEATURES
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.report.brdf.brdf_object import doubts, is_open, is_poor, is_tied
from ipcli.stages.brdf.parameters import BrdfModel
from ipcli.stages.kit.artefact import Beside, Job, Outcome, make
from ipcli.stages.kit.pages import page
from ipcli.stages.kit.summary import Figure, of_result

log = logging.getLogger(__name__)
SUMMARISED = ("sheet", "residual", "tie", "materials", "material_posterior", "metrics")
SMALLEST = 24  # pixels along the longer side of an object, below which patches and cells are too few


@dataclass(frozen=True)
class ObjectFiles:
    """The files of one object."""

    library: Path
    photo: Path
    mask: Path
    truth_normals: Path | None = None
    truth_height: Path | None = None
    convention: str = "opengl"  # of the normals that are given
    normals: Path | None = None

    @property
    def inputs(self) -> tuple[Path, ...]:
        """All files that are read."""
        return tuple(
            p for p in (self.library, self.photo, self.mask, self.truth_normals, self.truth_height, self.normals) if p
        )


def run(source: ObjectFiles, output: Path, params: BrdfModel, run: Run, progress: Progress = silent) -> Outcome:
    """Write the object and beside it a mesh (.ply), a printable relief (.stl), a normal map (.normals.png) and a
    page (.html).
    """
    beside: dict[Path, Beside] = {
        output.with_suffix(".ply"): write_mesh,
        output.with_suffix(".stl"): partial(write_relief, params),
        output.with_suffix(".normals.png"): partial(write_normals, params),
    }
    beside |= page(output, "brdf-object")
    job = Job(output, "brdf-object", "brdf-model", params, source.inputs, beside, partial(opened, source, params))
    return make(job, lambda: modelled(source, params, progress), run)


def modelled(source: ObjectFiles, params: BrdfModel, progress: Progress) -> dict[str, np.ndarray]:
    """The arrays of the `brdf-object` artefact."""
    shelf, photo, truth = opened(source, params)
    box = box_of(photo.mask)
    mask = photo.mask[box]
    if max(mask.shape) < SMALLEST:
        size = max(mask.shape)
        raise NoSolution(f"the object is {size} pixels long: give a picture of it with {SMALLEST} or more")
    if not photo.colour[box][mask].any():
        raise NoSolution("the object is black all over: check that --mask is white where the object is")
    if source.normals:
        given = photographs.read_normals(source.normals, source.convention, photo.mask.shape)[box]
        made = integrated(given, photo.colour[box], mask, shelf, params.inference)
    else:
        made = reconstruct(photo.colour[box], mask, shelf, params.inference, progress)
    arrays = described(made, photo, box, shelf, params)
    for doubt in doubts(arrays):
        log.warning("%s: %s", source.photo, doubt)
    return arrays | judged(arrays, truth)


def opened(source: ObjectFiles, params: BrdfModel) -> tuple[Library, Photograph, dict[str, np.ndarray]]:
    """Library, photograph and truth, all before the work: a file of another kind is told at once."""
    shelf = library_of(source.library)
    photo = photographs.read(source.photo, source.mask, params.response)
    return shelf, photo, read_truth(source, photo.mask.shape)


def library_of(path: Path) -> Library:
    """The library of a file. Raises FormatError, for a list of materials with the way to a library."""
    if path.suffix.lower() == ".toml":
        fix = f"Learn the library first: brdf-train {path.name} -o {path.stem}.h5"
        raise FormatError(path, "a list of materials, not a library", expected="what brdf-train wrote (.h5)", fix=fix)
    try:
        return Library.of(h5.read(path, "brdf-library").arrays)
    except ValueError as error:
        raise FormatError(path, f"a library that cannot be used: {error}", fix="Learn it again by brdf-train") from None


def box_of(mask: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns of the mask."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def described(
    made: Reconstruction, photo: Photograph, box: tuple[slice, slice], shelf: Any, params: BrdfModel
) -> dict[str, np.ndarray]:
    """The surface in the frame of the picture, and how it came to be."""

    def whole(part: np.ndarray) -> np.ndarray:
        image = np.full((*photo.mask.shape, *part.shape[2:]), np.nan, np.float32)
        image[box] = part
        return image

    grey = photo.colour.mean(axis=-1)
    scale = max(float(np.percentile(grey[photo.mask], 95)), 1e-9)
    width = params.printing.width
    extra = {
        key: whole(part)
        for key, part in (("solid_height", made.solid_height), ("sheet_height", made.sheet_height))
        if part is not None
    }
    return extra | {
        "picture": photo.shown,
        "mask": photo.mask.astype(np.uint8),
        "height": whole(made.height),
        "normals": whole(made.normals),
        "confidence": whole(made.confidence),
        "initial_height": whole(made.prior),
        "shading": whole(made.shading),
        "intensity": np.where(photo.mask, grey / scale, np.nan).astype(np.float32),
        "reflectance": made.chart.astype(np.float32),
        "sheet": np.array(made.sheet, np.float64),
        "rim_features": np.array(FEATURES),
        "rim_values": made.features,
        "residual": np.array(made.residual),
        "tie": np.array(made.tie, np.float64),
        "light_above": np.array(made.is_above, np.uint8),
        "saturated": np.array(photo.saturated),
        "pixel_size": np.array(width / (box[1].stop - box[1].start) if width else 1.0, np.float64),
        "unit": np.array("mm" if width else "px"),
        "materials": np.array(shelf.materials),
        "material_posterior": made.material_posterior(shelf),
        "probes": np.array(shelf.probes),
        "probe_posterior": made.probe_posterior(shelf),
    }


def read_truth(source: ObjectFiles, shape: tuple[int, int]) -> dict[str, np.ndarray]:
    """The true normals (h, w, 3) and heights (h, w), of a picture (h, w), that are given."""
    truth = {}
    if source.truth_normals:
        truth["truth_normals"] = photographs.read_normals(source.truth_normals, source.convention, shape)
    if source.truth_height:
        truth["truth_height"] = photographs.read_height(source.truth_height, shape)
    return {name: values.astype(np.float32) for name, values in truth.items()}


def judged(arrays: Mapping[str, np.ndarray], truth: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Errors of the surface and of the shapes that need no picture, where the truth is given."""
    mask = arrays["mask"] > 0
    if not truth:
        return {}
    box = box_of(mask)
    shapes = {"this surface": arrays["height"][box]}
    shapes |= {
        name: arrays[key][box]
        for name, key in (("as a solid", "solid_height"), ("as a sheet", "sheet_height"))
        if key in arrays
    }
    shapes |= baselines(mask[box])
    known = {key: value[box] for key, value in truth.items()}
    rows = [
        evaluation.errors(shape, mask[box], known.get("truth_normals"), known.get("truth_height"))
        for shape in shapes.values()
    ]
    columns = np.array(evaluation.COLUMNS)
    return dict(truth) | {"metrics": np.array(rows), "metric_rows": np.array(list(shapes)), "metric_columns": columns}


def write_mesh(path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The visible surface with normals, colours and confidence, x right, y up, z to the viewer."""
    vertices, faces, pixels = front(arrays["height"].astype(np.float64), float(arrays["pixel_size"]))
    ply.write(
        path,
        vertices.astype(np.float32),
        faces=faces,
        normals=arrays["normals"].reshape(-1, 3)[pixels],
        colors=arrays["picture"].reshape(-1, 3)[pixels],
        extra={"confidence": arrays["confidence"].ravel()[pixels]},
        comments=(f"ipcli brdf-model, orthographic, unit {arrays['unit']}, digest {provenance['digest']}",),
    )


def write_relief(
    params: BrdfModel, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]
) -> None:
    """The surface on a back plate, closed, as binary STL."""
    print_as = params.printing
    height = print_as.depth * arrays["height"].astype(np.float64)
    stl.write(
        path,
        *closed(height, float(arrays["pixel_size"]), print_as.plate),
        f"ipcli brdf-model {provenance['digest'][:16]}",
    )


def write_normals(
    params: BrdfModel, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]
) -> None:
    """The normal map as a 16-bit PNG in the convention asked for."""
    images.write_png(path, photographs.encode_normals(arrays["normals"], params.normals))


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of an object."""
    arrays = h5.read(output, "brdf-object", lambda name: name in SUMMARISED).arrays
    sheet, residual, tie = (float(arrays[key]) for key in ("sheet", "residual", "tie"))
    edge = "open" if is_open(arrays) else "no, a rim" if sheet < 0.5 else "yes"
    told = "no, it ties" if is_tied(arrays) else "yes" if np.isfinite(tie) else "not asked"
    best, count = int(arrays["material_posterior"].argmax()), len(arrays["materials"])
    name, share = str(arrays["materials"][best]), float(arrays["material_posterior"][best])
    facts: dict[str, Any] = {
        "cut edge": Figure(round(sheet, 2), f"{edge} (probability {sheet:.2f})"),
        "residual": Figure(round(residual, 4), f"{residual:.4f} of the bright values{', poor' * is_poor(arrays)}"),
        "settled by the picture": Figure(
            {"convex or concave": told == "yes", "tie": tie}, f"convex or concave: {told}"
        ),
        "material": Figure({"name": name, "posterior": share}, f"{name} ({share:.2f}, of {count} in the library)"),
    }
    if "metrics" in arrays:
        facts["N-MAE, rad"] = round(float(arrays["metrics"][0, 0]), 4)
    return facts
