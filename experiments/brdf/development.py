"""What chapter 7 was developed on: MIT's cup1, meshes and sheets in measured materials under real probes.

None of it is in the library: other shapes, MERL's materials as networks, Debevec's probes at headings of their own.
"""

from __future__ import annotations

import tarfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from experiments.brdf import scenes
from experiments.brdf.scenes import Case
from ipcli.io.files import images
from ipcli.io.materials import measured, probes
from ipcli.io.meshes import mesh
from ipcli.models.brdf import meshes, surfaces
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.grid import inflate, normals
from ipcli.models.brdf.light import probe
from ipcli.models.brdf.materials import Network
from ipcli.models.brdf.reflectance import charts
from ipcli.models.brdf.surfaces import ImplicitSurface
from ipcli.rng import stream

MESHES = ("spot", "cow", "teapot", "rocker-arm", "suzanne", "cheburashka", "beetle", "homer", "fandisk", "tm_tube")
SHEETS, GENERATED = 10, 34
LIGHTS = ("ennis", "grace", "pisa", "uffizi", "wells")
MATERIALS = (
    "white-paint",
    "pink-felt",
    "pvc",
    "light-red-paint",
    "yellow-matte-plastic",
    "teflon",
    "white-fabric",
    "red-specular-plastic",
    "gold-metallic-paint",
    "alum-bronze",
)
GLOSSY = ("brass", "steel", "aluminium", "blue-acrylic", "specular-black-phenolic", "pvc", "red-specular-plastic")
SIDE = 128


def cases(data: Path, sheets: int = SHEETS, solids: int = len(MESHES)) -> Iterator[Case]:
    """cup1, then each mesh and each sheet with one material under one probe."""
    yield from scenes.mit(data, ("cup1",))
    for number, made in enumerate([*_meshes(data / "brdf/meshes/meshes.tar.xz", solids), *_sheets(sheets)]):
        rng = stream(13, "development", str(number))
        yield _seen(made, data, "sheet" if made.is_sheet else "mesh", MATERIALS[number % len(MATERIALS)], number, rng)


def with_solids(data: Path) -> Iterator[Case]:
    """The `cases`, and the solids among some generated ones, summed up by themselves."""
    yield from cases(data)
    for case in generated_cases(data, GENERATED):
        if not case.name.startswith("sheet"):
            yield replace(case, name=f"generated {case.name}", kind="Generated solids")


def generated_cases(data: Path, count: int) -> Iterator[Case]:
    """Surfaces of the families that libraries learn from, in glossy materials too: `experiments/brdf/rims.py`."""
    materials = (*MATERIALS, *GLOSSY)
    for number in range(count):
        rng = stream(13, "generated", str(number))
        yield _seen(generated.surface(rng, SIDE), data, "generated", materials[number % len(materials)], number, rng)


def _seen(made: ImplicitSurface, data: Path, group: str, material: str, number: int, rng: np.random.Generator) -> Case:
    """The surface in a measured material under one of LIGHTS, at a heading of its own."""
    image = probes.read(data / f"brdf/hdri_debevec_small/{LIGHTS[number % len(LIGHTS)]}.hdr")
    network = Network(measured.read_network(data / "brdf/nbrdf_merl/merl_nbrdf_100.npz", material))
    chart = np.maximum(charts(network, [probe(image, rng.uniform(0, 2 * np.pi))])[0], 0)
    picture = generated.photograph(made, chart, rng)
    return Case(f"{made.name} {material}", group, picture, made.mask, made.normals, made.height)


def _meshes(archive: Path, count: int) -> Iterator[ImplicitSurface]:
    """Meshes of the archive, each turned by an angle up to 40 degrees."""
    with TemporaryDirectory() as folder, tarfile.open(archive) as packed:
        packed.extractall(folder, filter="data")
        for name in MESHES[:count]:
            rng = stream(13, "mesh", name)
            read = mesh.read(Path(folder) / f"meshes/{name}.obj")
            yield generated.cropped(meshes.seen(*read, SIDE, surfaces.rotation(rng, 0.7), name))


def _sheets(count: int) -> Iterator[ImplicitSurface]:
    """Crumpled papers and stuffed bags, in turn."""
    for number in range(count):
        rng = stream(13, "sheet", str(number))
        mask = _rectangle(rng)
        z = _paper(rng, mask) if number % 2 else _bag(rng, mask)
        height = np.where(mask, z, np.nan)
        name = f"{'paper' if number % 2 else 'bag'} {number}"
        yield generated.cropped(ImplicitSurface(mask, height, normals(height, mask), True, name))


def _rectangle(rng: np.random.Generator) -> np.ndarray:
    """A rectangle of pixels with rounded, uneven edges."""
    axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    turn = rng.uniform(-0.3, 0.3)
    u, v = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
    a, b = rng.uniform(0.5, 0.75, 2)
    edge = [0.03 * np.sin(rng.uniform(2, 6) * axis_ + rng.uniform(0, 6)) for axis_ in (v, u)]
    return np.abs(u) ** 9 / (a + edge[0]) ** 9 + np.abs(v) ** 9 / (b + edge[1]) ** 9 < 1


def _creases(rng: np.random.Generator, count: int, size: float) -> np.ndarray:
    """Soft folds (s, s) along random lines, in pixels."""
    axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    z = np.zeros((SIDE, SIDE))
    for _ in range(count):
        angle, at = rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5)
        along = np.cos(angle) * x + np.sin(angle) * y - at
        z += rng.normal(0, size) * np.sqrt(along**2 + 0.04**2)
    return z * SIDE / 2


def _paper(rng: np.random.Generator, mask: np.ndarray) -> np.ndarray:
    axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    tilt = rng.normal(0, 0.3, 2)
    return _creases(rng, 8, 0.35) + (tilt[0] * x + tilt[1] * y) * SIDE / 2


def _bag(rng: np.random.Generator, mask: np.ndarray) -> np.ndarray:
    """What is stuffed: a flattened balloon in a flat seam, creased."""
    from scipy.ndimage import binary_erosion, gaussian_filter

    inner = binary_erosion(mask, iterations=int(rng.integers(4, 9)))
    return rng.uniform(0.2, 0.5) * gaussian_filter(inflate(inner), 2.0) + _creases(rng, 5, 0.08)


def picture(case: Case, path: Path) -> None:
    """The picture of a case as PNG, for the eye."""
    images.write_png(path, np.rint(255 * np.clip(case.colour, 0, 1) ** (1 / 2.2)).astype(np.uint8))
