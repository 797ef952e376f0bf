"""The page of a `gaze-experiment`: path and map from two sides, points of regard on frames and on a panorama, GRIC
curves, coherent subsequences, accuracy where the truth is known, and what was lost.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.geometry.alignment import path_extent
from ipcli.report.gaze.panorama import panorama, with_regards
from ipcli.report.gaze.sides import from_above, from_the_side
from ipcli.report.kit import pictures
from ipcli.report.kit.curves import Series, plot
from ipcli.report.kit.numbers import DASH, counted, number, percent, with_unit
from ipcli.report.kit.page import TURNED, Markup, element, figure, gallery, join, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import photograph
from ipcli.report.kit.provenance import origin

ROWS = 60  # of a table: more are summed up
HIT = "hit"
MOST_AREAS = 12  # whose ways to each other still make a table


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of an experiment, the same bytes for the same artefact; no picture is stored wider than `widest`."""
    a = arrays
    parts = [notice(str(text)) for text in a["notes"]]
    parts += [_sides(a), *_accuracy(a), *_areas(a), *_landmarks(a), _frames(a, widest), _panorama(a, widest)]
    parts += [*_curves(a), _subsequences(a), _tracking(a), _calibration(a), *_lost(a), _reading(a), origin(provenance)]
    title = "Where the wearer was, and what they looked at" if _has_gaze(a) else "Where the wearer was"
    return document(title, "ipcli gaze-sfm", _verdict(a), *parts)


def _has_gaze(a: Mapping[str, np.ndarray]) -> bool:
    return "por/outcome" in a


def _verdict(a: Mapping[str, np.ndarray]) -> str:
    count, lost = len(a["lost"]), int(a["lost"].sum())
    words = f"{count - lost} of {count} head poses over {with_unit(float(a['times'][-1] - a['times'][0]), 's')}, "
    split = counted(len(a["subsequences/frames"]), "coherent subsequence")
    words += f"a map of {len(a['map/points'])} points, {split}."
    length, farthest = path_extent(a["world_from_rig"])
    words += f" The path is {with_unit(length, 'm')} long and gets {with_unit(farthest, 'm')} away from its start."
    if _has_gaze(a):
        hit = a["por/outcome"] == HIT
        words += f" {int(hit.sum())} of {len(hit)} gaze samples have a point of regard"
        sigma = np.sqrt(np.trace(a["por/covariance"][hit], axis1=1, axis2=2))
        words += f", known to {with_unit(float(np.median(sigma)), 'm', 2)} (median)." if hit.any() else "."
    if "accuracy/path" in a:
        words += f" Against the truth the path is off by {with_unit(float(a['accuracy/path'][0]), 'm')} (RMS)."
    return words


def _sides(a: Mapping[str, np.ndarray]) -> Markup:
    regards = ", points of regard (red)" if _has_gaze(a) else ""
    lead = join(
        f"The head's path (blue){regards} and the map (grey), in the frame of the first picture: x to its right, z the "
        "way it looked. The page ",
        TURNED,
        " beside this one shows the same to be turned.",
    )
    both = gallery(from_above(a), from_the_side(a), columns=2)
    return section("Path and map", both, lead=lead)


def _accuracy(a: Mapping[str, np.ndarray]) -> list[Markup]:
    parts = []
    is_known = bool(np.isfinite(a.get("accuracy/rms", np.array([]))).any())  # where what was looked at is
    if "accuracy/path" in a:
        rigid, similar, scale, online = (float(value) for value in a["accuracy/path"])
        rows = [["path", number(rigid), number(similar), number(scale, 5), number(online)]]
        head = ["RMS error, m", "rigid alignment", "with scale", "scale", "as known online"]
        parts.append(table(head, rows))
    if len(a.get("accuracy/labels", ())):
        rows = [
            [label, f"{regards}", number(float(dwell)), number(float(rms)), *map(percent, inside.tolist())]
            for label, regards, dwell, rms, inside in zip(
                a["accuracy/labels"], a["accuracy/regards"], a["accuracy/dwell"], a["accuracy/rms"],
                a["accuracy/inside"], strict=True,
            )
        ]  # fmt: skip
        head = ["looked at", "points of regard", "time on it, s", "RMS error, m", "truth in 68 % region", "in 95 %"]
        told = slice(None) if is_known else slice(3)
        parts.append(table(head[told], [row[told] for row in rows]))
    lead = "Errors where the truth is known."
    if is_known:
        lead += " The regions are honest when they hold the truth as often as they say."
    return [section("Accuracy", *parts, lead=lead)] if parts else []


def _areas(a: Mapping[str, np.ndarray]) -> list[Markup]:
    """Time on each area of interest, and the ways between them."""
    if "aoi/names" not in a:
        return []
    names = a["aoi/names"].tolist()
    rows = [
        [name, number(float(dwell)), percent(float(share)), f"{visits}", f"{fixations}",
         number(float(first)) if np.isfinite(first) else "never"]
        for name, dwell, share, visits, fixations, first in zip(
            names, a["aoi/dwell"], a["aoi/share"], a["aoi/visits"], a["aoi/fixations"], a["aoi/first"], strict=True
        )
    ]  # fmt: skip
    head = ["area", "time on it, s", "of the known gaze", "visits", "fixations", "first look, s"]
    ways = [[name, *map(str, moves)] for name, moves in zip(names, a["aoi/transitions"].tolist(), strict=True)]
    parts = [table(head, rows[:ROWS])]
    if 1 < len(names) <= MOST_AREAS:
        parts.append(table(["from, to", *names], ways))
    lead = "A point of regard counts for the nearest area within the margin. The second table counts the ways between."
    return [section("Areas of interest", *parts, lead=lead)]


def _landmarks(a: Mapping[str, np.ndarray]) -> list[Markup]:
    """How well the landmarks fit that the world was laid on."""
    if "landmarks/names" not in a:
        return []
    off = np.linalg.norm(a["landmarks/found"] - a["landmarks/places"], axis=1)
    rows = [
        [name, number(float(rest)) if np.isfinite(rest) else "not seen"]
        for name, rest in zip(a["landmarks/names"].tolist(), off, strict=True)
    ]
    lead = f"The world is that of these landmarks; the run was scaled by {number(float(a['landmarks/scale']), 5)}."
    return [section("World", table(["landmark", "off by, m"], rows), lead=lead)]


def _frames(a: Mapping[str, np.ndarray], widest: int) -> Markup:
    shown = [
        figure(
            photograph(with_regards(a, n), widest),
            f"Frame {frame}",
            f"subsequence {a['subsequence'][frame]}" if not a["lost"][frame] else "lost: " + str(a["reasons"][frame]),
        )
        for n, frame in enumerate(a["picture_frames"])
    ]
    title, lead = "Pictures on the way", "Some of the left camera's pictures."
    if _has_gaze(a):
        title = "What was looked at"
        lead = (
            "Points of regard (red, the nearest in time in yellow) in some of the pictures: 15 at most, as in (3.34)."
        )
    return section(title, gallery(*shown, columns=4, small=True), lead=lead)


def _panorama(a: Mapping[str, np.ndarray], widest: int) -> Markup:
    lead = "Some pictures laid around the middle of the head's path"
    lead += ", with all points of regard (figure 3.3)." if _has_gaze(a) else " (figure 3.3)."
    return section("Panorama", figure(photograph(panorama(a), widest), "All around", ""), lead=lead)


def _curves(a: Mapping[str, np.ndarray]) -> list[Markup]:
    """Figure 3.6: both scores and their difference; the difference and delta; keyframes as dashed lines. Nothing of
    what is known of no frame.
    """
    frame = np.arange(len(a["times"]), dtype=float)
    difference = a["gric_f"] - a["gric_h"]
    scores = [
        Series("Γ(F)", frame, a["gric_f"]),
        Series("Γ(H)", frame, a["gric_h"]),
        Series("Γ(F) − Γ(H)", frame, difference),
    ]
    turns = [Series("δ, px", frame, a["change"])]
    if _has_gaze(a):
        turns.insert(0, Series("gaze from the subsequence's PORs, σ", frame, a["parted"]))
    shown = [
        plot([*lines, _keys(a, lines)], title, "frame", label, from_zero=from_zero)
        for lines, title, label, from_zero in (
            (scores, "Motion models", "score", False),
            (turns, "Change of gaze" if _has_gaze(a) else "Change of the view", "see the legend", True),
        )
        if any(np.isfinite(line.y).any() for line in lines)
    ]
    lead = (
        "The lower score explains the motion since the last keyframe better: a homography (H) when the head turned, "
        "a fundamental matrix (F) when it moved. Dashed: keyframes, where attention turned elsewhere (figure 3.6)"
        f"{'' if _has_gaze(a) else '; the middle of the picture stands for the gaze'}."
    )
    return [section("Keyframes", element("div", *shown, class_="plots"), lead=lead)] if shown else []


def _keys(a: Mapping[str, np.ndarray], series: list[Series]) -> Series:
    values = np.concatenate([line.y[np.isfinite(line.y)] for line in series])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    keys = np.flatnonzero(a["keyframe"]).astype(float)
    x = np.stack([keys, keys, np.full(len(keys), np.nan)], axis=1).ravel()
    y = np.tile([low, high, np.nan], len(keys))
    return Series("keyframes", x, y, dashed=True)


def _subsequences(a: Mapping[str, np.ndarray]) -> Markup:
    head = ["subsequence", "frames", "seconds"]
    head += ["points of regard", "median place x, y, z, m", "extent, m"] if _has_gaze(a) else []
    rows = []
    for n, ((first, stop), regards, point, extent) in enumerate(
        zip(*(a[f"subsequences/{name}"] for name in ("frames", "regards", "points", "extent")), strict=True)
    ):
        seconds = float(a["times"][stop - 1] - a["times"][first])
        place = ", ".join(number(float(value)) for value in point) if np.isfinite(point).all() else DASH
        cells = [f"{n}", f"{first}–{stop - 1}", number(seconds), f"{regards}", place, number(float(extent))]
        rows.append(cells[: len(head)])
    rest = [notice(f"{len(rows) - ROWS} more subsequences are in the artefact.")] if len(rows) > ROWS else []
    what = "one focus of attention" if _has_gaze(a) else "much the same before the head"
    return section("Coherent subsequences", table(head, rows[:ROWS]), *rest, lead=f"Runs of frames with {what}.")


def _tracking(a: Mapping[str, np.ndarray]) -> Markup:
    frame, begins = np.arange(len(a["times"]), dtype=float), a["how"] == "first"
    matched, error = (np.where(begins, np.nan, a[name]) for name in ("matched", "error"))  # it rests on no map
    shown = [
        plot(
            [Series("between the cameras", frame, a["stereo"]), Series("with the map", frame, matched)],
            "Matches", "frame", "points", from_zero=True,
        ),
        plot([Series("error", frame, error)], "Reprojection error", "frame", "px", from_zero=True),
    ]  # fmt: skip
    return section("Tracking", element("div", *shown, class_="plots"), lead="What each head pose rests on.")


def _calibration(a: Mapping[str, np.ndarray]) -> Markup:
    parts, vertical = a["offset_blocks"], a["vertical"][np.isfinite(a["vertical"])]
    told = {
        "offset of the right camera, whole sequence": [float(a["offset_estimate"])],
        "in contiguous parts": parts[np.isfinite(parts)].tolist(),
        "standard error of their mean": [float(a["offset_error"])],
        "applied": [float(a["offset"])],
        "vertical disparity, median": [float(np.median(vertical))] if len(vertical) else [],
    }
    rows = [
        [name, ", ".join(map(number, values)) + "\N{NO-BREAK SPACE}px"]
        for name, values in told.items()
        if len(values) and np.isfinite(values).all()
    ]
    lead = "A constant error of the disparities, as the sequence itself shows it; corrected only where it is certain."
    return section("Calibration", table(["", ""], rows), lead=lead)


def _lost(a: Mapping[str, np.ndarray]) -> list[Markup]:
    frames = np.flatnonzero(a["lost"])
    rows = [[str(a["names"][k]), str(a["reasons"][k])] for k in frames[:ROWS]]
    parts = [table(["frame", "why"], rows)] if len(rows) else []
    if "por/outcome" in a:
        names, counts = np.unique(a["por/outcome"], return_counts=True)
        parts.append(
            table(
                ["gaze sample", "number", "share"],
                [[n, f"{c}", percent(c / counts.sum())] for n, c in zip(names, counts, strict=True)],
            )
        )
    return [section("What was lost, and why", *parts)] if parts else []


def _reading(a: Mapping[str, np.ndarray]) -> Markup:
    text = (
        "Depth of a point of regard is that of the scene along the gaze ray, never the eyes' vergence. Its covariance "
        "holds the error of the gaze carried over the surface, that of the surface and that of the head pose. "
        if _has_gaze(a)
        else ""
    )
    lost = "Lost frames have no pose: NaN in the artefact, left out of the trajectory."
    return section("How to read it", element("p", text + lost))
