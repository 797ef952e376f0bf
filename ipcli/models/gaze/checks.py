"""Does a recording's calibration suit its pictures? Epipolar residuals, swapped cameras, dark frames, clocks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipcli.geometry.rig import Rig
from ipcli.measurements.recording import Gaze, HeadRecording
from ipcli.models.gaze import features, localise, regard
from ipcli.models.gaze.parameters import Localisation

WIDE = 12.0  # rows searched for partners, so that a bad calibration shows
VERTICAL = 1.0  # pixels of vertical disparity above which a calibration is doubted
NEAR, APART = 0.005, 2.0  # metres between the cameras of a rig that nobody doubts
FAR_OFF = 5.0  # pixels of an offset that no loose mount explains
FEW = 30  # stereo points below which a pair says nothing


@dataclass(frozen=True, eq=False)
class Pair:
    """What one pair says."""

    name: str
    features: int
    matched: int
    swapped: int  # matched when left and right are exchanged
    vertical: float  # median vertical disparity, pixels
    spread: float  # robust standard deviation of it
    slope: float  # of the vertical disparity over the rows, pixels from top to bottom
    usable: bool


def pairs(recording: HeadRecording, p: Localisation, count: int) -> list[Pair]:
    """Some pairs, evenly spread."""
    rig = localise.rig_of(recording)
    wide = replace(p.detection, band=WIDE)
    chosen = np.unique(np.linspace(0, len(recording.names) - 1, count).astype(int))
    return [_pair(recording, int(k), rig, wide) for k in chosen]


def _pair(recording: HeadRecording, k: int, rig: Rig, p) -> Pair:
    frame = recording.load(k)
    found = features.extract(frame.left, frame.right, frame.depth, rig, p)
    hit = np.isfinite(found.points).all(axis=1)
    if frame.right is None or hit.sum() < 2:
        return Pair(recording.names[k], len(found), int(hit.sum()), 0, np.nan, np.nan, np.nan, found.usable)
    left, right = rig.rectified(0, found.left[hit]), rig.rectified(1, found.right[hit])
    vertical = left[:, 1] - right[:, 1]
    middle = float(np.median(vertical))
    spread = 1.4826 * float(np.median(np.abs(vertical - middle)))
    good = np.abs(vertical - middle) < max(3 * spread, 0.5)
    slope = np.polyfit(left[good, 1] / rig.sizes[0, 1], vertical[good], 1)[0] if good.sum() > 10 else np.nan
    other = features.extract(frame.right, frame.left, None, rig, p)
    swapped = int(np.isfinite(other.points).all(axis=1).sum())
    return Pair(recording.names[k], len(found), int(hit.sum()), swapped, middle, spread, float(slope), found.usable)


def verdict(recording: HeadRecording, found: list[Pair]) -> tuple[dict[str, object], list[str]]:
    """Figures and warnings."""
    facts: dict[str, object] = {
        "layout": recording.source,
        "frames": len(recording.names),
        "seconds": round(float(recording.times[-1] - recording.times[0]), 3),
        "features a picture (median)": int(np.median([pair.features for pair in found])),
    }
    words = [*recording.dropped, *(recording.gaze.dropped if recording.gaze else ())]
    dark = [pair.name for pair in found if not pair.usable]
    if dark:
        words.append(f"{len(dark)} of {len(found)} pictures show nothing, the first is {dark[0]}")
    if recording.is_stereo:
        words += _stereo(facts, found) + rig_words(localise.rig_of(recording))
    return facts, words + _gaze(facts, recording)


def _stereo(facts: dict[str, object], found: list[Pair]) -> list[str]:
    matched, swapped = (float(np.median([getattr(pair, name) for pair in found])) for name in ("matched", "swapped"))
    verticals = np.array([pair.vertical for pair in found if pair.matched >= FEW])
    vertical = float(np.median(verticals)) if len(verticals) else float("nan")
    spread = float(np.nanmedian([pair.spread for pair in found])) if len(verticals) else float("nan")
    slopes = [pair.slope for pair in found if np.isfinite(pair.slope)]
    slope = float(np.median(slopes)) if slopes else float("nan")
    facts |= {
        "matched between the cameras (median)": int(matched),
        "matched if left and right are exchanged": int(swapped),
        "vertical disparity [px]": round(vertical, 3),
        "its spread [px]": round(spread, 3),
        "its change from top to bottom [px]": round(slope, 3),
    }
    words = []
    if swapped > 2 * max(matched, 5):
        words.append(
            "left and right are exchanged: points would lie behind the cameras; exchange pictures or calibration"
        )
    elif matched < FEW:
        words.append(
            f"only {int(matched)} features match between the cameras: is the calibration that of these pictures?"
        )
    if abs(vertical) > VERTICAL or spread > 2 * VERTICAL:
        words.append(
            f"rows differ by {vertical:.2f} px (spread {spread:.2f}): the calibration is of another rig or time"
        )
    return words


def rig_words(rig: Rig) -> list[str]:
    """What is odd about two cameras on a head: how far apart they are, and on which side, in metres, and by how many
    pixels the disparities of what they saw are off.
    """
    if not rig.is_stereo:
        return []
    found = []
    centre = np.linalg.inv(rig.cam_from_rig[1])[:3, 3]
    if not NEAR < rig.baseline < APART:
        found.append(f"the cameras are {rig.baseline:.3g} m apart: is the calibration in another unit than metres?")
    if -centre[0] > rig.baseline / 2:
        found.append(
            "by the calibration the second camera is to the left of the first: exchange the cameras, or invert its pose"
        )
    if abs(rig.offset) > FAR_OFF:
        found.append(
            f"the disparities are {rig.offset:.1f} px off: the calibration is of another rig, or left and right are "
            "exchanged"
        )
    return found


def gaze_words(gaze: Gaze | None) -> list[str]:
    """Whether pixels of the gaze are but shares of the picture."""
    known = gaze.pixels[gaze.valid & np.isfinite(gaze.pixels).all(axis=1)] if gaze is not None else np.zeros((0, 2))
    if len(known) > FEW and known.min() >= 0 and known.max() <= 1:
        return ["all gaze lies in the first pixel: it is given as shares of the picture; multiply by width and height"]
    return []


def _gaze(facts: dict[str, object], recording: HeadRecording) -> list[str]:
    gaze = recording.gaze
    if gaze is None or not len(gaze.times):
        return ["no gaze: give --gaze; without, there are no points of regard"]
    rig = localise.rig_of(recording)
    gap = float(np.median(np.diff(recording.times))) if len(recording.times) > 1 else 1.0
    paired = regard.nearest_frames(recording.times, gaze.times, 0.75 * gap) >= 0
    _, _, inside = regard.rays_of(gaze, rig)
    facts |= {
        "gaze samples": len(gaze.times),
        "gaze rate [Hz]": round(1 / float(np.median(np.diff(gaze.times))), 1) if len(gaze.times) > 1 else float("nan"),
        "gaze samples with a frame": round(float(paired.mean()), 3),
        "valid gaze samples": round(float(gaze.valid.mean()), 3),
        "gaze inside the picture": round(float(inside.mean()), 3),
    }
    words = gaze_words(gaze)
    if paired.mean() < 0.5:
        words.append(
            f"{100 * paired.mean():.0f} % of the gaze has a frame of its time: check the clocks (--gaze-shift)"
        )
    if inside.mean() < 0.7:
        words.append(
            f"{100 * (1 - inside.mean()):.0f} % of the gaze lies outside the picture: check --gaze-size and axes"
        )
    return words
