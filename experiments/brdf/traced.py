"""Pictures by another renderer: objects of our own, path traced by Mitsuba 3 with cast shadows and inter-reflection.

Our forward model knows neither, and its materials are written by other hands there: what is measured on these pictures
is no inverse crime. Needs the extra `mitsuba`; `scalar_rgb` is taken, which needs no LLVM.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from experiments.brdf import scenes
from experiments.kit.tables import write_table
from ipcli.geometry.meshes import vertex_normals
from ipcli.io.files import atomic, ply
from ipcli.models.brdf import evaluation, surfaces
from ipcli.models.brdf import materials as models
from ipcli.models.brdf import scenes as generated
from ipcli.models.brdf.grid import inflate
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.light import DIRECTIONS, key_and_fill, probe, sphere
from ipcli.models.brdf.materials import Brdf
from ipcli.models.brdf.parameters import Inference
from ipcli.models.brdf.reconstruct import reconstruct
from ipcli.models.brdf.reflectance import charts, shade
from ipcli.models.brdf.surfaces import Implicit, ImplicitSurface
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import page, section, table
from ipcli.rng import stream
from ipcli.stages.brdf import materials as lists

Triangles = tuple[np.ndarray, np.ndarray]  # vertices (n, 3) and faces (m, 3)
LIST = Path(__file__).resolve().parents[2] / "sample_data/brdf/materials.toml"
SIDE, SAMPLES = 192, 144  # of a picture, of a pixel
QUICK_SIDE, QUICK_SAMPLES = 64, 9
PROBE = 64  # rows of the probe
REACH = 1.1  # half the cube that solids are meshed in
VOXELS = 160  # along its edge


@dataclass(frozen=True)
class Traced:
    """One object in one material under one light."""

    name: str
    kind: str
    inflation: float  # N-MAE, rad, of the inflated outline,
    ours: float  # of ours on the picture by our own forward model,
    traced: float  # and on the traced one
    apart: float  # mean difference of the two pictures over the mean of ours, both exposed alike


def measured(shelf: Library, params: Inference, quick: bool) -> Iterator[Traced]:
    """Every object in every material of the sample's list, each under a studio light of its own."""
    listed = lists.read(LIST)
    side, samples = (QUICK_SIDE, QUICK_SAMPLES) if quick else (SIDE, SAMPLES)
    for name, solid in list(scenes.solids().items())[: 2 if quick else None]:
        made, mesh = surfaces.march(solid, side, name), meshed(solid)
        for material, entry in list(listed.materials.items())[: 2 if quick else None]:
            rng = stream(13, "traced", f"{name} {material}")
            image = equirectangular(key_and_fill(rng).radiance)
            seen = trace(mesh, lists.brdf(entry), image, side, samples)[made.mask]
            chart = np.maximum(charts(lists.brdf(entry), [probe(image)])[0], 0)
            told = compared(made, shade(chart, made.normals[made.mask]), seen, shelf, params, rng)
            kind = "Metals" if lists.is_metal(entry) else "Plastics"
            yield Traced(f"{name} {material}", kind, *told)


def compared(
    made: ImplicitSurface,
    own: np.ndarray,
    traced: np.ndarray,
    shelf: Library,
    params: Inference,
    rng: np.random.Generator,
) -> tuple[float, float, float, float]:
    """The figures of `Traced` from the radiance (n, 3) at the mask by either renderer."""
    pictures = [generated.exposed(seen, made.mask, rng) for seen in (own, traced)]
    rows, columns = (np.flatnonzero(made.mask.any(axis=axis)) for axis in (1, 0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    mask, normals = made.mask[box], made.normals[box]
    heights = [inflate(mask), *(reconstruct(p[box], mask, shelf, params).height for p in pictures)]
    errors = [evaluation.errors(height, mask, normals, None)[0] for height in heights]
    ours, other = (picture[made.mask] for picture in pictures)
    return errors[0], errors[1], errors[2], float(np.abs(ours - other).mean() / ours.mean())


def trace(
    solid: Triangles, brdf: Brdf, image: np.ndarray, side: int, samples: int, bounces: int | None = None
) -> np.ndarray:
    """Radiance (side, side, 3) towards +z of a solid within [-1, 1]^3 under an equirectangular probe (h, w, 3).

    `bounces` bounds how often light is reflected, 1: directly lit alone. Pixels that see nothing are 0.
    """
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    towards = mitsuba.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": side, "height": side, "pixel_format": "rgba", "component_format": "float32"}
    sampler = {"type": "multijitter", "sample_count": samples}
    depth = -1 if bounces is None else bounces + 1
    with TemporaryDirectory() as folder:
        path = Path(folder) / "solid.ply"
        vertices, faces = solid
        ply.write(path, vertices, faces=faces, normals=vertex_normals(vertices, faces))
        scene = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "hide_emitters": True},
            "solid": {"type": "ply", "filename": str(path), "bsdf": plugin(brdf)},
            "light": {"type": "envmap", "bitmap": mitsuba.Bitmap(image.astype(np.float32))},
            "sensor": {
                "type": "orthographic",
                "near_clip": 0.1,
                "far_clip": 10.0,
                "to_world": towards,
                "film": film | {"rfilter": {"type": "box"}},
                "sampler": sampler,
            },
        }
        seen = np.array(mitsuba.render(mitsuba.load_dict(scene)))
    return seen[..., :3] / np.maximum(seen[..., 3:], 1e-6)


def plugin(brdf: Brdf) -> dict[str, object]:
    """The BSDF of Mitsuba for one of our analytic ones. ValueError for what is measured, which it has no plugin for.

    Its plastic also scatters light between ground and coat, which ours does not.
    """
    if isinstance(brdf, models.Matte):
        return {"type": "diffuse", "reflectance": _rgb(brdf.albedo)}
    if isinstance(brdf, models.Conductor):
        lobe = {"type": "roughconductor", "distribution": "ggx", "alpha": brdf.roughness}
        return lobe | {"eta": _rgb(brdf.eta), "k": _rgb(brdf.kappa)}
    if isinstance(brdf, models.Plastic):
        coat = {"type": "roughplastic", "distribution": "ggx", "alpha": brdf.roughness, "int_ior": brdf.eta}
        return coat | {"nonlinear": True, "diffuse_reflectance": _rgb(brdf.diffuse)}
    raise ValueError(f"no plugin of Mitsuba for {type(brdf).__name__}")


def _rgb(values: tuple[float, ...]) -> dict[str, object]:
    return {"type": "rgb", "value": list(values)}


def meshed(solid: Implicit) -> Triangles:
    """A closed mesh (n, 3) float32, (m, 3) of an implicit solid by marching cubes, faces outward."""
    from skimage.measure import marching_cubes

    axis = np.linspace(-REACH, REACH, VOXELS)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    values = np.stack([solid(np.stack([x, y, np.full_like(x, z)], axis=-1)) for z in axis], axis=-1)
    vertices, faces, _, _ = marching_cubes(values, 0.0, spacing=(axis[1] - axis[0],) * 3, gradient_direction="descent")
    return (vertices - REACH).astype(np.float32), faces


def equirectangular(radiance: np.ndarray) -> np.ndarray:
    """A probe (h, 2 h, 3) as `light.probe` reads it: at each texel the radiance (d, 3) of the nearest direction."""
    from scipy.spatial import cKDTree

    step = np.pi / PROBE
    theta, phi = np.meshgrid((np.arange(PROBE) + 0.5) * step, (np.arange(2 * PROBE) + 0.5) * step, indexing="ij")
    towards = np.stack([np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], axis=-1)
    return radiance[cKDTree(sphere(DIRECTIONS)).query(towards)[1]]


def write(folder: Path, found: list[Traced]) -> None:
    """CSV, JSON and page."""
    write_table(folder / "traced.csv", [asdict(one) for one in found], study="traced")
    rows = []
    for kind in dict.fromkeys(one.kind for one in found):
        mine = [one for one in found if one.kind == kind]
        inflation, ours, traced, apart = (
            float(np.mean([getattr(one, key) for one in mine])) for key in ("inflation", "ours", "traced", "apart")
        )
        worse = sum(one.traced > one.inflation + np.radians(2) for one in mine)
        gains = (f"{100 * (error / inflation - 1):+.0f} %" for error in (ours, traced))
        rows.append((kind, number(inflation), *gains, f"{100 * apart:.0f} %", f"{worse} of {len(mine)}"))
        print("  ".join(rows[-1]))
    heads = ("Kind", "inflation, rad", "ours, own pictures", "ours, traced", "pictures apart", "worse by 2° or more")
    lead = "N-MAE against the inflated outline's. Traced: cast shadows, inter-reflection, the BSDFs of Mitsuba."
    each = [
        (one.name, *map(number, (one.inflation, one.ours, one.traced)), f"{100 * one.apart:.0f} %") for one in found
    ]
    parts = [
        section("Metals and plastics", table(heads, rows), lead=lead),
        section("Each picture", table(("Picture", "inflation", "own picture", "traced", "pictures apart"), each)),
    ]
    verdict = f"{len(found)} pictures, each by two renderers under one light."
    atomic.write_text(
        folder / "index.html", page("Surfaces from path-traced pictures", "experiments/brdf", verdict, *parts)
    )
