"""Long takes with a label for every frame: `python mocap_takes.py string IN.clips.h5 OUT.clips.h5 ACTOR...` strings
them from clips, `python mocap_takes.py page OUT.html FILE.recognition.h5...` tells how they were recognised, with X.csv
and X.json beside.

Each actor's clips follow one another in an order drawn once. A clip starts where the one before ended and faces the
same way; between them the pose jumps, as it does nowhere in life, so what happens at the joins is not to be taken for
segmentation of real takes.
"""

import csv
import io
import json
import sys
from pathlib import Path

import numpy as np

from experiments.mocap import takes_page
from ipcli.geometry.motion import heading
from ipcli.geometry.skeleton import Groups
from ipcli.io.files import atomic, h5
from ipcli.io.motion import artefact
from ipcli.io.motion.groups import find
from ipcli.measurements.motions import Clip, Motion
from ipcli.report.mocap.action_recognition import shares_of_time
from ipcli.rng import stream

TITLE = "Long takes of people not learnt from"
LEAD = (
    "Clips of one actor after the other make a take with a label for every frame; between clips the pose jumps. The "
    "model knows the other "
    "actors alone. Order plays no part in it: a window is asked about as a set of frames."
)
SHOWN = 1.0  # seconds, the window of the timelines


def strung(parts: list[Clip], groups: Groups, actor: str) -> Clip:
    """One take of all parts, in this order."""
    root = parts[0].motion.skeleton.indices([groups.root])[0]
    positions, rotations = [], []
    for clip in parts:
        motion = clip.motion
        turn, move = np.eye(3), np.zeros(3)
        if positions:
            before = Motion(motion.skeleton, positions[-1], motion.rate)
            turn = (
                heading(before.skeleton, before.positions, groups)[-1]
                @ heading(motion.skeleton, motion.positions, groups)[0].T
            )
            level = np.array([1.0, 0.0, 1.0])  # heights stay as they are
            move = level * (positions[-1][-1, root] - turn @ motion.positions[0, root])
        positions.append(motion.positions @ turn.T + move)
        if motion.rotations is not None:
            rotations.append(turn @ motion.rotations)
    whole = np.concatenate(rotations) if len(rotations) == len(parts) else None
    labels = np.repeat([clip.label for clip in parts], [len(clip.motion.positions) for clip in parts])
    return Clip(
        f"take of {actor}",
        Motion(parts[0].motion.skeleton, np.concatenate(positions), parts[0].motion.rate, whole),
        "",
        actor,
        labels,
    )


def takes(path: Path, actors: list[str], seed: int = 0) -> list[Clip]:
    """A take of each actor; ends with a word when one has no clips."""
    found = artefact.read_clips(path)
    if unknown := [actor for actor in actors if actor not in found.actors]:
        raise SystemExit(f"{path}: no clip of {unknown[0]}. There are clips of {', '.join(sorted(set(found.actors)))}")
    groups = find("auto", found.skeleton)
    made = []
    for actor in actors:
        mine = [name for name, other in zip(found.names, found.actors, strict=True) if other == actor]
        order = stream(seed, "mocap-takes", actor).permutation(len(mine))
        made.append(strung([found.load(mine[index]) for index in order], groups, actor))
    return made


def rows_of(found: dict[tuple[float, bool], dict[str, np.ndarray]]) -> list[dict[str, object]]:
    """A row for each length of the window, with "none" allowed or not."""
    rows = []
    for (window, allowed), arrays in found.items():
        right, unnamed = shares_of_time(arrays)
        rows.append(
            {
                "window s": window,
                "none allowed": allowed,
                "time named right %": round(100 * right, 2),
                "called none %": round(100 * unnamed, 2),
            }
        )
    return rows


def write_page(out: Path, files: list[Path]) -> None:
    """The page, and what it tells as CSV and JSON."""
    found = {}
    for path in files:
        artefact = h5.read(path, "action-recognition")
        found[artefact.provenance["params"]["window"], artefact.provenance["params"]["none"]] = artefact.arrays
    rows, text = rows_of(found), io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic.write_text(out.with_suffix(".csv"), text.getvalue())
    atomic.write_text(out.with_suffix(".json"), json.dumps({"title": TITLE, "rows": rows}, indent=1) + "\n")
    atomic.write_text(out, takes_page.page(TITLE, LEAD, found, (SHOWN, True)))


if __name__ == "__main__":
    task, *arguments = sys.argv[1:]
    if task == "string":
        source, target, *actors = arguments
        h5.write(Path(target), "clips", artefact.clips_arrays(takes(Path(source), actors), {}), {})
    else:
        write_page(Path(arguments[0]), [Path(file) for file in arguments[1:]])
