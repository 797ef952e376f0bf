"""The page of `saliency`: what was looked at and what was predicted, proto-objects, and what each feature is worth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import pictures
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, element, figure, gallery, meter, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.kit.pictures import Scale, draw, photograph
from ipcli.report.kit.provenance import origin

RED, GREEN = (214, 58, 58), (60, 190, 90)
ROWS = 40  # of a table
SALIENCY = Scale(0.0, 1.0, "magma")


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = pictures.WIDEST) -> str:
    """The HTML of a `saliency` artefact, the same bytes for the same artefact."""
    a = arrays
    parts = [notice(str(text)) for text in a["notes"]]
    parts += [_frames(a, widest), _objects(a), *_errors(a), *_rankings(a), *_groups(a), _subsequences(a), _reading(a)]
    return document("What is likely to be looked at", "ipcli saliency", _verdict(a), *parts, origin(provenance))


def _has_gaze(a: Mapping[str, np.ndarray]) -> bool:
    return bool(a["subsequences/regards"].any())


def _verdict(a: Mapping[str, np.ndarray]) -> str:
    tracks = len(np.unique(a["objects/track"]))
    words = (
        f"{len(a['objects/track'])} proto-objects at {tracks} places in {len(a['subsequences/frames'])} subsequences."
    )
    if np.isfinite(a["hits"]).all():
        (now, now_chance), (ever, ever_chance) = a["hits"].tolist()
        words += f" {percent(ever)} of them lie where somebody looked, {percent(now)} at that very time; by chance "
        words += f"{percent(ever_chance)} and {percent(now_chance)} would."
    if len(a.get("folds/rates", ())):
        words += (
            f" The learnt function has a balanced error rate of {number(float(np.nanmean(a['folds/rates'][:, 4])))}."
        )
    return words


def marked(a: Mapping[str, np.ndarray], n: int) -> np.ndarray:
    """The n-th picture with points of regard in red and predicted patches in green (figure 3.15)."""
    import cv2

    image = np.array(a["pictures/images"][n])  # a copy: the artefact is drawn from, never drawn into
    mine = a["outlines/picture"] == n
    for item in np.unique(a["outlines/object"][mine]):
        rim = np.rint(a["outlines/pixels"][mine & (a["outlines/object"] == item)]).astype(np.int32)
        tinted = image.copy()
        cv2.fillPoly(tinted, [rim], GREEN)
        image = cv2.addWeighted(tinted, 0.3, image, 0.7, 0)
        cv2.polylines(image, [rim], True, GREEN, 2, cv2.LINE_AA)
    for u, v in a["regards/pixels"][a["regards/picture"] == n]:
        at = (round(float(u)), round(float(v)))
        cv2.circle(image, at, 4, (255, 255, 255), -1, cv2.LINE_AA)
        cv2.circle(image, at, 3, RED, -1, cv2.LINE_AA)
    return image


def _frames(a: Mapping[str, np.ndarray], widest: int) -> Markup:
    shown = []
    for n, frame in enumerate(a["pictures/frames"]):
        shown.append(
            figure(photograph(marked(a, n), widest), f"Frame {frame}", f"subsequence {a['pictures/subsequence'][n]}")
        )
        shown.append(figure(draw(a["pictures/maps"][n], SALIENCY, widest), f"Saliency, frame {frame}", scale=SALIENCY))
    title, lead = "What was predicted", "Proto-objects in green"
    if _has_gaze(a):
        title, lead = "What was looked at, and what was predicted", "Points of regard in red, proto-objects in green"
    lead += " (figure 3.15); beside each picture the saliency of its points, hatched where no surface is known."
    if len(a.get("folds/rates", ())):
        lead += " Proto-objects lie where the membranes are strongest, which need not be where the learnt function is."
    return section(title, gallery(*shown, columns=4, small=True), lead=lead)


def _objects(a: Mapping[str, np.ndarray]) -> Markup:
    words = {2: "yes", 1: "at another time", 0: "no", -1: "–"}
    rows = []
    for n in np.argsort(-a["objects/saliency"], kind="stable")[:ROWS]:
        first, last = (number(float(time)) for time in a["objects/times"][n])
        place = ", ".join(number(float(value)) for value in a["objects/places"][n])
        rows.append(
            [f"{a['objects/track'][n]}", f"{a['objects/subsequence'][n]}", f"{first}–{last}", place,
             meter(float(a["objects/saliency"][n]), number(float(a["objects/saliency"][n]))),
             words[int(a["objects/hit"][n])]]
        )  # fmt: skip
    head = ["place", "subsequence", "seconds", "x, y, z, m", "saliency"]
    if _has_gaze(a):
        head.append("looked at")
    rows = [row[: len(head)] for row in rows]
    lead = (
        f"Patches of {number(float(a['radius']))} m around maxima of the membranes' energy. Those of one place in "
        "several subsequences bear the same number: what lasts is no false alarm."
    )
    return section("Proto-objects", table(head, rows), lead=lead)


def _errors(a: Mapping[str, np.ndarray]) -> list[Markup]:
    if not len(a.get("folds/rates", ())):
        return []
    rows = [
        [f"{n + 1}", f"{int(rates[0])}", *(number(float(value)) for value in rates[1:3]), percent(float(rates[3])),
         number(float(rates[4]))]
        for n, rates in enumerate(a["folds/rates"])
    ]  # fmt: skip
    head = ["fold", "positives", "misses wp+/|D|+", "false alarms wp−/|D|−", "accuracy", "balanced error rate (3.35)"]
    lead = "Each fold predicted by a function learnt from the others, as in table 3.1."
    return [section("The learnt function", table(head, rows), lead=lead)]


def _rankings(a: Mapping[str, np.ndarray]) -> list[Markup]:
    values = a["subsequences/ranking"]
    if not np.isfinite(values).any():
        return []
    rows = []
    for k, name in enumerate(a["rankings"]):
        known = values[:, k][np.isfinite(values[:, k])]
        mean = float(known.mean()) if len(known) else float("nan")
        rows.append([str(name), meter(mean, number(mean)), f"{len(known)}"])
    lead = (
        "How often a point that was looked at scores above one that nobody looked at, within a subsequence: 0.5 is "
        "chance, below it the opposite predicts."
    )
    head = ["score", "area under the curve", "subsequences"]
    return [section("What each score is worth", table(head, rows), lead=lead)]


def _groups(a: Mapping[str, np.ndarray]) -> list[Markup]:
    if not len(a.get("groups/names", ())):
        return []
    order = np.argsort(a["groups/balanced"], kind="stable")
    listed = [[str(a["groups/names"][n]), number(float(a["groups/balanced"][n]))] for n in order]
    best = [row for row in listed if not row[0].startswith("all but")][:12]
    rest = [row for row in listed[::-1] if row[0].startswith("all but")]
    path = [
        [str(name), number(float(value))]
        for name, value in zip(a["elimination/names"], a["elimination/balanced"], strict=True)
    ]
    head = ["groups of features", "balanced error rate"]
    parts = [table(head, best), element("p", "All but one, the one that is missed most first:"), table(head, rest)]
    parts += [element("p", "Elimination, from all groups to one:"), table(head, path)]
    return [
        section("Groups of features", *parts, lead="The best few groups taken together, and what elimination leaves.")
    ]


def _subsequences(a: Mapping[str, np.ndarray]) -> Markup:
    rows = []
    for n, (first, stop) in enumerate(a["subsequences/frames"][:ROWS]):
        rows.append(
            [f"{n}", f"{first}–{stop - 1}", f"{a['subsequences/nodes'][n]}", number(float(a["subsequences/error"][n])),
             f"{a['subsequences/regards'][n]}", percent(float(a["subsequences/attended"][n, 0]))]
        )  # fmt: skip
    head = ["subsequence", "frames", "nodes", "residual of the surface, m"]
    head += ["points of regard", "nodes attended"] if _has_gaze(a) else []
    return section("Surfaces", table(head, [row[: len(head)] for row in rows]))


def _reading(a: Mapping[str, np.ndarray]) -> Markup:
    text = (
        "Saliency is the learnt function as a probability, for as many attended points as others; where nothing is "
        "learnt, the rank of the membranes' energy. Each subsequence is predicted by a function that has not seen it."
    )
    return section("How to read it", element("p", text))
