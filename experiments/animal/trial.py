"""One animal, several methods: `python -m experiments.animal.trial NAME OUT.json --cache DIR [--sets ...]`.

Part masks are rendered from the ground truth with real occlusion; cameras are estimated from them (scale and shift by
the silhouettes; with --blind only the first view has a name, and the rest are found by the overlap of all labels; a
three-quarter view never has one). Distances are over the diagonal of the truth's box.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np
import trimesh

from experiments.animal import meshes, symmetry
from ipcli.geometry.distances import apart
from ipcli.geometry.orthographic import Orthographic, angle_between, looking, of_view
from ipcli.geometry.part_masks import framed, render
from ipcli.io.files import atomic
from ipcli.measurements.part_images import PartImage
from ipcli.models.animal import baselines, whole
from ipcli.models.animal.aspects import lift_all
from ipcli.models.animal.parameters import FIELDS, MERGES, SEARCHES, Modelling, Volume
from ipcli.models.animal.placing import placed

LONGEST = 350  # pixels of the longer side of the animal in each image
THREE_QUARTER = {"three-quarter": (40.0, 15.0), "three-quarter-back": (215.0, 20.0)}  # azimuth, elevation
SETS = {
    "two silhouettes": ("left", "right", "front", "back"),
    "three silhouettes": ("left", "right", "front", "back", "top"),
    "two and three-quarter": ("left", "right", "front", "back", "three-quarter"),
    "four silhouettes": ("left", "right", "front", "back", "top", "three-quarter"),
}
HULLS = ("visual hull", "visual hull, rims kept")
AGAINST = {  # what the model is compared with; the whole mask is the same in all sets, and the thesis has four images
    "two silhouettes": (*HULLS, "whole mask inflated", "thesis as printed"),
    "three silhouettes": HULLS,
}


def shots(animal: meshes.Animal, views, is_blind: bool, noise: float = 0.0, seed: int = 0):
    """Images of an animal and their true cameras; `noise` pixels of contour noise."""
    taken = []
    for number, view in enumerate(views):
        rotation = looking(*THREE_QUARTER[view]) if view in THREE_QUARTER else of_view(view)
        camera, shape = framed(animal.vertices, rotation, LONGEST)
        labels, _ = render(animal.vertices, animal.faces, animal.labels, camera, shape)
        if noise:
            labels = jagged(labels, noise, np.random.default_rng([seed, number]))
        has_name = view not in THREE_QUARTER and (number == 0 or not is_blind)
        taken.append((PartImage(view, labels, view if has_name else None), camera))
    return taken


def jagged(labels: np.ndarray, pixels: float, rng: np.random.Generator) -> np.ndarray:
    """A label image whose contours wander by so many pixels (root mean square), over lengths of some ten pixels."""
    from scipy.ndimage import gaussian_filter

    rows, columns = np.mgrid[: labels.shape[0], : labels.shape[1]]
    moved = []
    for at, size in ((rows, labels.shape[0]), (columns, labels.shape[1])):
        shift = gaussian_filter(rng.normal(size=labels.shape), 4.0)
        moved.append(np.clip(np.rint(at + pixels * shift / shift.std()), 0, size - 1).astype(int))
    return labels[moved[0], moved[1]]


def to_truth(vertices: np.ndarray, cameras, truth: list[Orthographic]) -> np.ndarray:
    """Model vertices in the world of the truth. The first camera is shared: its rotation is given, its scale known; the
    offset is the one that the cameras agree on best.
    """
    rows = np.vstack([camera.rotation[:2] for camera in truth])
    offset = np.concatenate([(c.shift - t.shift) / t.scale for c, t in zip(cameras, truth, strict=True)])
    return vertices * (cameras[0].scale / truth[0].scale) + np.linalg.lstsq(rows, offset, rcond=None)[0]


def methods(images, cameras, tree, params: Modelling):
    """Each method's name with a function that makes its mesh."""
    hull = baselines.visual_hull
    return {
        "visual hull": lambda: hull(images, cameras, params.volume.voxels),
        "visual hull, rims kept": lambda: hull(images, cameras, params.volume.voxels, is_rounded=True),
        "whole mask inflated": lambda: baselines.whole_mask(images[0], cameras[0], params.inflation),
        "thesis as printed": lambda: baselines.as_printed(images, cameras, tree, params),
    }


def symmetric(images, cameras, tree, params: Modelling) -> whole.PartedSurface:
    """The model in which the left and the right limb of a pair share their aspects."""
    aspects, _ = symmetry.shared(lift_all(images, tree, params.inflation), images, tree.names, params.registration)
    heights = {key: aspect.picture for key, aspect in aspects.items()}
    fields, shots, grid = whole.parts_of(images, cameras, tree, heights, params.volume)
    return whole.surface(fields, shots, grid, params.volume)


def run(
    animal: meshes.Animal, views, is_blind: bool, noise: float, params: Modelling, against=(), is_symmetric=False
) -> dict:
    """All figures of one animal from one set of views, and those of the methods `against`."""
    images, truth = map(list, zip(*shots(animal, views, is_blind, noise), strict=True))
    started = time.process_time()
    cameras = placed(images, animal.tree, params)
    placing = time.process_time() - started
    surface = (symmetric if is_symmetric else whole.model)(images, cameras, animal.tree, params)
    seconds = time.process_time() - started
    goal = (animal.vertices, animal.faces)
    body = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    results = {"ours": asdict(apart((to_truth(surface.vertices, cameras, truth), surface.faces), goal))}
    make = methods(images, cameras, animal.tree, params)
    for name in against:
        vertices, faces = make[name]()
        results[name] = asdict(apart((to_truth(vertices, cameras, truth), faces), goal))
    angles = [angle_between(c.rotation, t.rotation) for c, t in zip(cameras, truth, strict=True)]
    searched = {image.name: angle for image, angle in zip(images, angles, strict=True) if image.view is None}
    return {"methods": results, "seconds": seconds, "seconds_cameras": placing, "watertight": bool(body.is_watertight),
            "searched": searched}  # fmt: skip


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name")
    parser.add_argument("out", type=Path)
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--sets", default=",".join(SETS))
    parser.add_argument("--noise", type=float, default=0.0)
    parser.add_argument("--blind", action="store_true")
    parser.add_argument("--alone", action="store_true", help="our method only")
    parser.add_argument("--merge", choices=MERGES, default="hull")
    parser.add_argument("--field", choices=FIELDS, default="sdf")
    parser.add_argument("--search", choices=SEARCHES, default="image")
    given = parser.parse_args()
    animal = meshes.load(given.cache, given.name)
    params = Modelling(volume=Volume(merge=given.merge, field=given.field), search=given.search)
    rows = {
        name: run(animal, SETS[name], given.blind, given.noise, params, () if given.alone else AGAINST.get(name, ()))
        for name in given.sets.split(",")
    }
    about = {"name": given.name, "species": meshes.SPECIES.get(given.name, given.name), "noise": given.noise,
             "blind": given.blind, "development": given.name in meshes.DEVELOPMENT, "params": asdict(params),
             "sets": rows}  # fmt: skip
    atomic.write_text(given.out, json.dumps(about, indent=1) + "\n")


if __name__ == "__main__":
    main()
