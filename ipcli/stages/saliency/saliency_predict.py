"""saliency-predict: pictures, or a mesh or cloud -> how likely each place is looked at."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, IpcliError
from ipcli.executor import map_items
from ipcli.geometry.upright import upright
from ipcli.io.files import atomic, h5, images, ply
from ipcli.io.meshes import mesh, turntable
from ipcli.models.saliency import image_model, vertex_model
from ipcli.models.saliency.channels import shrunk
from ipcli.models.saliency.learning import Predictor
from ipcli.models.saliency.vertex_features import upright_normals
from ipcli.params import Run
from ipcli.progress import Progress, silent
from ipcli.report.kit.pictures import from_zero, palette
from ipcli.report.saliency.overlay import PALETTE
from ipcli.stages.kit.artefact import Beside, Job, Outcome, make
from ipcli.stages.kit.pages import page, turning_page
from ipcli.stages.kit.summary import of_result
from ipcli.stages.saliency.parameters import SaliencyPredict

log = logging.getLogger(__name__)
KIND = "saliency-maps"
FEWEST = 100  # points of a surface
MOST_TURNED = 150_000  # triangles, or points, of a page to be turned
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")


def run(
    source: Path, output: Path, model: Path | None, params: SaliencyPredict, run: Run, progress: Progress = silent
) -> Outcome:
    """Write the maps and beside them a page (.html) and for each picture its map as grey levels (.NAME.png), for a
    surface its cloud or mesh with a property `saliency` (.NAME.ply).

    Pictures of a folder that cannot be read do not stop the others: IpcliError names them when those are done.
    """
    beside: dict[Path, Beside] = {}
    broken: dict[str, str] = {}
    if source.suffix.lower() in mesh.JOINED:
        files = {source.stem: source}
        beside[output.with_suffix(f".{source.stem}.ply")] = partial(write_surface, source)
        beside[turning_page(output)] = partial(write_turnable, f"saliency-predict: {output.name}", source, params.up)
        build, look = partial(of_surface, source, model, params.up), partial(_look, model, "surfaces", source)
    else:
        files, broken = readable(pictures_of(source))
        beside |= {output.with_suffix(f".{name}.png"): partial(write_map, name) for name in files}
        build, look = partial(predicted, files, model, params, run, progress), partial(_look, model, "pictures")
    inputs = (*files.values(), *([model] if model else []))
    job = Job(output, KIND, "saliency-predict", params, inputs, beside | page(output, KIND), look)
    outcome = make(job, build, run)
    if broken:
        left = "; ".join(f"{name}: {reason}" for name, reason in broken.items())
        total = len(files) + len(broken)
        raise IpcliError(f"{len(broken)} of {total} pictures left out of {output}: {left}. Mend or remove them")
    return outcome


def _look(model: Path | None, subject: str, source: Path | None = None) -> None:
    predictor_of(model, subject)
    if source:
        read_surface(source)


def read_surface(source: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Points (n, 3), unit normals (n, 3) and triangles (m, 3), if there are, of a mesh or of a cloud (PLY). Raises
    FormatError for too few points, and for a cloud without normals.
    """
    if source.suffix.lower() != ".ply":
        vertices, faces = mesh.read_joined(source)
        if len(vertices) >= FEWEST:
            return vertices, upright_normals(vertices, faces), faces
        raise FormatError(source, "too few points", expected=f"{FEWEST} or more", got=len(vertices))
    declared = ply.header(source).elements
    if declared.get("face", (0, ()))[0]:
        vertices, faces = mesh.read(source)
        if len(vertices) >= FEWEST:
            return vertices, upright_normals(vertices, faces), faces
    else:
        cloud = ply.read(source)
        vertices = cloud.vertices.astype(np.float64)
        if cloud.normals is None:
            raise FormatError(source, "a cloud without normals", expected="nx, ny, nz", fix="Estimate them first")
        if len(vertices) >= FEWEST and np.isfinite(vertices).all():
            length = np.linalg.norm(cloud.normals, axis=1, keepdims=True)
            return vertices, cloud.normals / np.maximum(length, 1e-12), None
    raise FormatError(source, "too few points, or some not finite", expected=f"{FEWEST} or more", got=len(vertices))


def of_surface(source: Path, model: Path | None, up: str) -> dict[str, np.ndarray]:
    """The arrays of the `saliency-maps` artefact of a mesh or cloud, turned so that y points up and not `up`."""
    vertices, normals = (upright(vectors, up) for vectors in read_surface(source)[:2])
    known = predictor_of(model, "surfaces")
    return {
        "model": np.array(model.name if model else f"{vertex_model.UNTRAINED}, untrained"),
        f"surfaces/{source.stem}/points": vertices.astype(np.float32),
        f"surfaces/{source.stem}/normals": normals.astype(np.float32),
        f"surfaces/{source.stem}/map": vertex_model.saliency(vertices, normals, known),
    }


def write_surface(source: Path, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The surface with its saliency as a property of each point."""
    vertices, normals, faces = read_surface(source)
    ply.write(
        path,
        vertices.astype(np.float32),
        faces=faces,
        normals=normals.astype(np.float32),
        extra={"saliency": arrays[f"surfaces/{source.stem}/map"]},
        comments=(f"ipcli saliency-predict, digest {provenance['digest']}",),
    )


def write_turnable(
    title: str, source: Path, up: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]
) -> None:
    """A page with the surface to be turned, in the colours of its saliency; of a large one some of its points."""
    vertices, _, faces = read_surface(source)
    places, saliency = upright(vertices, up), arrays[f"surfaces/{source.stem}/map"]
    scale = from_zero([saliency], PALETTE, "times chance")
    colours = palette(PALETTE)[scale.indices(saliency[None])[0]]
    if faces is None or len(faces) > MOST_TURNED:
        chosen = slice(None, None, -(-len(places) // MOST_TURNED))
        scene = turntable.cloud_scene(places[chosen].astype(np.float32), colours[chosen])
    else:
        scene = turntable.surface_scene(places.astype(np.float32), faces, colours)
    about = "Bright is likely to be looked at, dark is not."
    atomic.write_text(path, turntable.turning_page(scene, title, about))


def pictures_of(source: Path) -> dict[str, Path]:
    """The pictures of a file or folder by the names of their maps. Raises FormatError for none."""
    if not source.exists():
        raise FormatError(source, "no such file or folder", fix="Check the path")
    inside = sorted(source.iterdir()) if source.is_dir() else [source]
    files = [path for path in inside if path.suffix.lower() in PICTURES and path.is_file()]
    if not files:
        expected = f"{' '.join(PICTURES)}, or a mesh or cloud ({' '.join(mesh.JOINED)})"
        some = next((path for path in inside if path.suffix.lower() in mesh.JOINED), None) if source.is_dir() else None
        fix = f"Surfaces are given one by one: {some}" if some else "Convert it"
        raise FormatError(source, "no picture and no surface", expected=expected, fix=fix)
    stems = [path.stem for path in files]
    return {path.stem if stems.count(path.stem) == 1 else path.name: path for path in files}


def readable(files: Mapping[str, Path]) -> tuple[dict[str, Path], dict[str, str]]:
    """The pictures that can be read, and why the others cannot. Raises the FormatError of the first if none can."""
    broken: dict[str, str] = {}
    for name, path in files.items():
        try:
            images.read_image(path)
        except FormatError as error:
            if len(broken) + 1 == len(files):
                raise
            broken[name] = str(error)
    return {name: path for name, path in files.items() if name not in broken}, broken


def predictor_of(model: Path | None, subject: str) -> Predictor | None:
    """The learnt predictor of a file. Raises FormatError for one that was learnt on something else."""
    if model is None:
        return None
    arrays = h5.read(model, "saliency-model").arrays
    if str(arrays["subject"]) != subject:
        fix = "Give another --model, or none"
        raise FormatError(model, f"was not learnt from {subject}", got=arrays["subject"], fix=fix)
    return Predictor.of(arrays)


def predicted(
    files: Mapping[str, Path], model: Path | None, params: SaliencyPredict, run: Run, progress: Progress
) -> dict[str, np.ndarray]:
    """The arrays of the `saliency-maps` artefact."""
    known = predictor_of(model, "pictures")
    found = map_items(partial(_of_picture, files, known, params.largest), list(files), run.executor, progress)
    arrays = {"model": np.array(model.name if model else image_model.UNTRAINED)}
    for name, (picture, saliency) in found.items():
        if np.ptp(saliency) == 0:
            log.warning("%s: nothing stands out: its map is flat and tells nothing", files[name])
        arrays |= {f"pictures/{name}/picture": picture, f"pictures/{name}/map": saliency}
    return arrays


def _of_picture(
    files: Mapping[str, Path], known: Predictor | None, largest: int, name: str
) -> tuple[np.ndarray, np.ndarray]:
    picture = images.read_image(files[name])
    kept = shrunk(picture, largest) if max(picture.shape[:2]) > largest else picture
    return kept, image_model.saliency(picture, known)


def write_map(name: str, path: Path, arrays: Mapping[str, np.ndarray], provenance: Mapping[str, Any]) -> None:
    """The map of a picture in grey levels, 255 where it is highest, at the size of the picture that is kept."""
    shape = arrays[f"pictures/{name}/picture"].shape[:2]
    images.write_png(path, image_model.grey(arrays[f"pictures/{name}/map"], (shape[0], shape[1])))


@of_result
def summary(output: Path) -> dict[str, Any]:
    """The few figures a person wants of maps."""
    names = h5.names(output)
    return {"by": str(h5.read(output, KIND, lambda name: name == "model").arrays["model"])} | {
        what: count
        for what in ("pictures", "surfaces")
        if (count := sum(name.startswith(what) and name.endswith("/map") for name in names))
    }
