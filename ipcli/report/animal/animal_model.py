"""The page of an `animal-model`: what it looks like from around, how it fits its images, and what nobody saw."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.animal import surfaces
from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import counted, percent
from ipcli.report.kit.page import (
    TURNED,
    Markup,
    columns_for,
    details,
    element,
    figure,
    gallery,
    join,
    meter,
    notice,
    section,
    table,
)
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import photograph
from ipcli.report.kit.provenance import origin

LONGEST = 420  # pixels of a turntable picture
AROUND = 8


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of an "animal-model" artefact; no picture is stored wider than `widest` pixels."""
    return document(
        f"Model of {arrays['name']}",
        "ipcli model-animal",
        _verdict(arrays),
        *map(notice, arrays["doubts"].tolist() if "doubts" in arrays else []),
        _warnings(arrays["warnings"].tolist()),
        _turning(arrays, widest),
        _images(arrays, widest),
        _registered(arrays, widest),
        _unseen(arrays, widest),
        _parts(arrays),
        origin(provenance),
    )


def _warnings(texts: list[str]) -> Markup:
    """What the masks lack, folded away where it is much."""
    if len(texts) < 4:
        return join(*map(notice, texts))
    summary = f"{len(texts)} masks tell no shape, or only a part of one"
    return details(summary, element("ul", *(element("li", text) for text in texts)))


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    fits = arrays["overlaps"]
    unseen = float((arrays["seen_by"] == 0).mean())
    parts = counted(len(np.unique(arrays["face_part"])), "part")
    least = percent(float(fits.min()))
    where = f"{least} of its pixels" if len(fits) == 1 else f"{least} or more of the pixels of each"
    return (
        f"One closed surface of {parts} and {len(arrays['faces'])} faces from {counted(len(fits), 'image')}; the model "
        f"shows the right part in {where}. {percent(unseen)} of its vertices were seen by no image: there it is a "
        "guess."
    )


def _turning(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    colours = surfaces.colours_of(arrays["face_part"])
    longest = min(LONGEST, widest)
    shots = surfaces.turntable(arrays["vertices"].astype(np.float64), arrays["faces"], colours, AROUND, longest)
    shown = [figure(photograph(shot, widest), f"{(45 + 360 * k // AROUND) % 360}°") for k, shot in enumerate(shots)]
    aspect = shots[0].shape[1] / shots[0].shape[0]
    lead = join(
        "From around, 15° from above; 0° is in front of the animal, 90° to its left. The page ",
        TURNED,
        " beside this one shows the same to be turned.",
    )
    return section(
        "The model", gallery(*shown, columns=columns_for(aspect, AROUND, small=True)), _legend(arrays), lead=lead
    )


def _legend(arrays: Mapping[str, np.ndarray]) -> Markup:
    present = np.isin(np.arange(len(arrays["parts"])), arrays["face_part"])
    names = arrays["parts"].tolist()
    swatches = [
        element("span", element("b", "■ ", style=f"color:{colour}"), name, style="margin-right:1.2em")
        for (name, colour), is_there in zip(surfaces.legend(names), present, strict=True)
        if is_there
    ]
    lost = [name for name, is_there in zip(names, present, strict=True) if not is_there]
    return element("p", *swatches, f"Not in the model: {', '.join(lost)}." if lost else "")


def _images(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    stems = [f"pictures/{number:03d}" for number in range(len(arrays["images"]))]
    layers = [(arrays[f"{stem}/labels"], arrays[f"{stem}/rendered"], arrays.get(f"{stem}/picture")) for stem in stems]
    drawn = surfaces.overlays(layers, arrays["scales"], min(LONGEST, widest))
    shown = []
    for number, name in enumerate(arrays["images"].tolist()):
        view = str(arrays["views"][number]) or "view found from the masks"
        note = f"{view}; {percent(float(arrays['overlaps'][number]))} of the pixels agree"
        shown.append(figure(photograph(drawn[number], widest), name, note))
    lead = (
        "The masks as they were given, around the animal and at one scale; black: the outlines of the model's parts, "
        "seen by the camera that was found."
    )
    aspect = drawn[0].shape[1] / drawn[0].shape[0]
    return section("Over its images", gallery(*shown, columns=columns_for(aspect, len(shown))), lead=lead)


def _registered(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    """Aspects of one part laid over each other, before and after; nothing where there are none."""
    stems = sorted(
        name.removesuffix("/part") for name in arrays if name.startswith("registrations/") and "/part" in name
    )
    shown = []
    for stem in stems:
        one, two = arrays[f"{stem}/images"].tolist()
        name = f"{arrays['parts'][int(arrays[f'{stem}/part'])]}: {two} over {one}"
        left = percent(float(arrays[f"{stem}/residual"]))
        fate = f"{left} of the heights differ; " + ("merged" if arrays[f"{stem}/is_used"] else "too much to merge")
        for key, note in (("before", "at the start"), ("after", fate)):
            drawn = surfaces.two_heights(arrays[f"{stem}/heights"], arrays[f"{stem}/{key}"])
            shown.append(figure(photograph(drawn, widest), name, note))
    if not shown:
        return join()
    lead = (
        "Images that show the same side of a part. Red: heights of the first alone, blue: of the second; grey: both "
        "agree. Merged aspects take the mean of both."
    )
    return section("Aspects laid over each other", gallery(*shown, columns=4), lead=lead)


def _unseen(arrays: Mapping[str, np.ndarray], widest: int) -> Markup:
    seen = arrays["seen_by"][arrays["faces"]].min(axis=1)
    ramp = pictures.palette("viridis")[2:]
    most = max(int(arrays["seen_by"].max()), 1)
    colours = ramp[np.minimum(seen * 253 // most, 253)].astype(np.float64)
    colours[seen == 0] = surfaces.UNSEEN
    shots = surfaces.turntable(arrays["vertices"].astype(np.float64), arrays["faces"], colours, 4, min(LONGEST, widest))
    shown = [figure(photograph(shot, widest), f"{(45 + 90 * k) % 360}°") for k, shot in enumerate(shots)]
    scale = f"Dark to bright: 1 to {most} images." if most > 1 else "In colour: one image saw it."
    lead = f"Grey: no image saw it. {scale}"
    return section("What the images saw", gallery(*shown, columns=4), lead=lead)


def _parts(arrays: Mapping[str, np.ndarray]) -> Markup:
    names = arrays["parts"].tolist()
    faces = np.bincount(arrays["face_part"], minlength=len(names))
    rows = [
        (name, f"{faces[part]}", *(_share(value) for value in arrays["part_overlaps"][:, part]))
        for part, name in enumerate(names)
    ]
    lead = "For each image the pixels in which image and model both show the part, over those in which either does."
    return section("Part by part", table(("part", "faces", *arrays["images"].tolist()), rows), lead=lead)


def _share(value: float) -> object:
    return "" if np.isnan(value) else meter(float(value), percent(float(value)))
