"""The contact sheet of a "clips" artefact: a clip of every action as poses over time, and who did what how often."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipcli.errors import IpcliError
from ipcli.geometry import motion as motions
from ipcli.geometry.skeleton import Groups
from ipcli.measurements.motions import Clips, Motion
from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number
from ipcli.report.kit.page import Markup, element, join, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.provenance import origin
from ipcli.report.kit.skeleton import bounds, pose_figure

MOST = 24  # actions drawn; the table has them all
POSES = 5  # of a clip, evenly spread over its time
UNKNOWN = "unlabelled"


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML page of a "clips" artefact, the same bytes for the same artefact; its drawings have no pixels
    to limit.
    """
    from ipcli.io.motion.artefact import of_arrays

    clips = of_arrays(arrays)
    if not clips.names:
        nothing = notice("there is nothing to show.")
        return document("Clips of motion", "ipcli clips", "The artefact holds no clip.", nothing, origin(provenance))
    said = [notice(f"{note}.") for note in map(str, arrays.get("notes", ()))]
    parts = (*said, _sheet(clips, _groups(clips)), _who(clips, arrays["frames"]), _splits(clips))
    return document("Clips of motion", "ipcli clips", _verdict(clips, arrays), *parts, origin(provenance))


def _verdict(clips: Clips, arrays: Mapping[str, np.ndarray]) -> str:
    frames, rates = int(arrays["frames"].sum()), sorted({float(rate) for rate in arrays["rates"]})
    seconds = float((arrays["frames"] / arrays["rates"]).sum())
    rate = f"{number(rates[0])} Hz" if len(rates) == 1 else f"{number(rates[0])} to {number(rates[-1])} Hz"
    seen = float(np.isfinite(arrays["positions"]).all(axis=-1).mean()) if arrays["positions"].size else 0.0
    have = "positions and rotations" if "rotations" in arrays else "positions"
    return (
        f"{len(clips.names)} clips of {len(set(clips.labels))} actions by {len(set(clips.actors))} actors: {frames} "
        f"frames at {rate}, "
        f"{number(seconds)} s in all. {have.capitalize()} of {len(clips.skeleton.joints)} joints, {100 * seen:.1f} % "
        "of them seen."
    )


def _groups(clips: Clips) -> Groups | None:
    from ipcli.io.motion import groups

    try:
        return groups.find("auto", clips.skeleton)
    except IpcliError:
        return None


def _sheet(clips: Clips, groups: Groups | None) -> Markup:
    labels = sorted(set(clips.labels))
    rows = []
    for label in labels[:MOST]:
        name = next(name for name, own in zip(clips.names, clips.labels, strict=True) if own == label)
        rows.append(_poses(clips, name, label or UNKNOWN, groups))
    lead = f"The first clip of each action at {POSES} evenly spread times, from the front and from the right"
    lead += (
        ", the body in the middle and turned as it faces in the first frame."
        if groups
        else ", in the frame of the world."
    )
    lead += f" {MOST} of {len(labels)} actions." if len(labels) > MOST else ""
    return section("Contact sheet", *rows, lead=lead)


def _poses(clips: Clips, name: str, label: str, groups: Groups | None) -> Markup:
    motion = clips.load(name).motion
    times = np.unique(np.linspace(0, len(motion.positions) - 1, POSES).round().astype(int))
    turned = _facing(motion, groups)[times]
    box, parents = bounds(list(turned)), np.array(clips.skeleton.parents)
    picked = np.ones(len(parents), bool)
    drawn = [
        pose_figure([pose], parents, picked, f"{number(time / motion.rate, 3)} s", box=box, height=130)
        for pose, time in zip(turned, times, strict=True)
    ]
    return join(element("h3", f"{label} "), element("p", name, class_="lead"), element("div", *drawn, class_="poses"))


def _facing(motion: Motion, groups: Groups | None) -> np.ndarray:
    """Positions (f, j, 3) with the middle of the joints above the origin, turned so that the body faces +z in the first
    frame.
    """
    known = np.isfinite(motion.positions).all(axis=-1)[..., None]
    middle = np.where(known, motion.positions, 0).sum(axis=1, keepdims=True) / np.maximum(
        known.sum(axis=1, keepdims=True), 1
    )
    turn = motions.heading(motion.skeleton, motion.positions, groups)[0] if groups else np.eye(3)
    return (motion.positions - middle * [1, 0, 1]) @ (turn if np.isfinite(turn).all() else np.eye(3))


def _who(clips: Clips, frames: np.ndarray) -> Markup:
    actors, labels = sorted(set(clips.actors)), sorted(set(clips.labels))
    pairs = list(zip(clips.labels, clips.actors, strict=True))
    rows = []
    for label in labels:
        own = [index for index, (name, _) in enumerate(pairs) if name == label]
        counts = [pairs.count((label, actor)) or "-" for actor in actors]
        rows.append([label or UNKNOWN, *counts, len(own), int(frames[own].sum())])
    total = [sum(actor == own for _, own in pairs) for actor in actors]
    rows.append(["all", *total, len(pairs), int(frames.sum())])
    heads = ("Action", *(actor or "unknown" for actor in actors), "Clips", "Frames")
    return section("Who did what", table(heads, rows), lead="Clips of each action by each actor.")


def _splits(clips: Clips) -> Markup:
    if not clips.splits:
        return join()
    rows = [[name, *(_side(clips, row == side) for side in (1, 2))] for name, row in clips.splits.items()]
    lead = "Actors with clips on both sides are named on both."
    return section("Published splits", table(("Split", "Clips to train on", "Clips to test on"), rows), lead=lead)


def _side(clips: Clips, chosen: Sequence[bool]) -> str:
    own = sorted({actor for actor, mine in zip(clips.actors, chosen, strict=True) if mine})
    return f"{int(np.sum(chosen))} ({', '.join(own)})"
