"""The page of a `recognition`: the answers, how sure they are and on whose account, and the segments of long takes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import number, percent
from ipcli.report.kit.page import Markup, element, join, meter, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.mocap import confusion, lanes

MOST_ROWS = 400
OF_CLIPS = "tells how few clips of people held out are as unlike their action: a tenth of them at 1, a hundredth at 2"
OF_PARTS = "is the typical distance of the frames from all that was learnt of the answer"


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of a `recognition` artefact; its figures are drawn, so there is nothing for ``widest`` to bound."""
    windows = "segment_clip" in arrays
    clips = list(dict.fromkeys(map(str, arrays["clips"])))
    title = clips[0] if len(clips) == 1 else f"{len(clips)} clips"
    return document(
        title,
        "ipcli mocap-classify",
        _verdict(arrays),
        *([_takes(arrays)] if windows else []),
        *([_confusions(arrays)] if "truth" in arrays else []),
        _answers(arrays),
        _groups(arrays),
        origin.origin(provenance),
    )


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    answers = arrays["answers"]
    unknown = int((answers == "none").sum())
    what = {"clip": "clips", "unordered": "draws of unordered frames", "window": "windows"}[str(arrays["queries"])]
    none = f", {unknown} of them as none of the {len(arrays['actions'])} actions" if unknown else ""
    if len(answers) == 1:
        sure = f" with posterior {percent(float(arrays['posterior'].max()))}" if not unknown else ""
        return f"{'No known action' if unknown else answers[0]}{sure}."
    told = f"{len(answers)} {what} were named{none}."
    if "truth_segment_clip" in arrays:
        right, unnamed = shares_of_time(arrays)
        return f"{told} Of the time that has a label, {percent(right)} was named right and {percent(unnamed)} none."
    if "truth" not in arrays:
        return told
    return " ".join([told, *_scores(arrays)])


def _scores(arrays: Mapping[str, np.ndarray]) -> list[str]:
    """How many answers were right: of labels that the model learnt, and apart from them of others, where none is."""
    answers, truth = arrays["answers"], arrays["truth"]
    learnt = np.isin(truth, arrays["actions"])
    strange = (truth != "") & ~learnt
    told = []
    if learnt.any() or not strange.any():
        right = float((answers == truth)[learnt].mean()) if learnt.any() else float("nan")
        told.append(f"{percent(right)} of the {int(learnt.sum())} whose label the model learnt were named right.")
    if strange.any():
        right = float((answers[strange] == "none").mean())
        told.append(f"{percent(right)} of the {int(strange.sum())} of labels that it never learnt were told as none.")
    return told


def shares_of_time(arrays: Mapping[str, np.ndarray]) -> tuple[float, float]:
    """Of the time that has a label, the share that its segments name right, and the share that they call none. NaN
    without labels.
    """
    right = unnamed = total = 0.0
    for name in dict.fromkeys(map(str, arrays["truth_segment_clip"])):
        found = _segments(arrays, "segment", name)
        for true in _segments(arrays, "truth_segment", name):
            common = [(one.name, max(min(one.end, true.end) - max(one.start, true.start), 0.0)) for one in found]
            right += sum(seconds for answer, seconds in common if answer == true.name)
            unnamed += sum(seconds for answer, seconds in common if answer == "none")
            total += true.end - true.start
    return (right / total, unnamed / total) if total else (float("nan"), float("nan"))


def _takes(arrays: Mapping[str, np.ndarray]) -> Markup:
    lead = "Along time, the action that was recognised (bars; the darker, the surer)"
    lead += " and the label that it has (outlines)." if "truth_segment_clip" in arrays else "."
    lead += " A gap: none of the actions." if (arrays["segment_answer"] == "none").any() else ""
    return section("Segments", *timelines(arrays), lead=lead)


def timelines(arrays: Mapping[str, np.ndarray]) -> list[Markup]:
    """A picture of lanes for each long take."""
    drawn = []
    for name in dict.fromkeys(map(str, arrays["segment_clip"])):
        found = _segments(arrays, "segment", name)
        truth = _segments(arrays, "truth_segment", name) if "truth_segment_clip" in arrays else []
        actions = [str(action) for action in arrays["actions"]]
        drawn.append(lanes.lanes(found, truth, actions, name))
    return drawn


def _segments(arrays: Mapping[str, np.ndarray], kind: str, clip: str) -> list[lanes.Segment]:
    mine = np.flatnonzero(arrays[f"{kind}_clip"] == clip)
    times, names = arrays[f"{kind}_time"], arrays[f"{kind}_answer"]
    sure = arrays[f"{kind}_posterior"] if f"{kind}_posterior" in arrays else np.ones(len(times))
    return [lanes.Segment(float(times[n, 0]), float(times[n, 1]), str(names[n]), float(sure[n])) for n in mine]


def answers_matrix(arrays: Mapping[str, np.ndarray]) -> Markup:
    """The matrix of confusions of an `action-recognition` as SVG: labels of the clips over answers, in percent."""
    rows, columns, counts = _counted(arrays)
    kept = counts.sum(axis=1) > 0
    named = [name for name, keep in zip(rows, kept, strict=True) if keep]
    return confusion.matrix(counts[kept], named, columns, "Answers")


def _counted(arrays: Mapping[str, np.ndarray]) -> tuple[list[str], list[str], np.ndarray]:
    """Labels, answers, and how many clips of each label got each answer."""
    actions = [str(action) for action in arrays["actions"]]
    columns = [*actions, "none"] if (arrays["answers"] == "none").any() else actions
    rows = list(dict.fromkeys([*actions, *(str(name) for name in np.unique(arrays["truth"]) if name)]))
    known = arrays["truth"] != ""
    pairs = zip(arrays["truth"][known], arrays["answers"][known], strict=True)
    counts = np.zeros((len(rows), len(columns)), np.int64)
    for truth, answer in pairs:
        counts[rows.index(str(truth)), columns.index(str(answer))] += 1
    return rows, columns, counts


def _confusions(arrays: Mapping[str, np.ndarray]) -> Markup:
    actions, rows = [str(action) for action in arrays["actions"]], _counted(arrays)[0]
    lead = "Rows are the labels of the clips, columns the answers, in percent of the row."
    if strange := [name for name in rows if name not in actions]:
        lead += f" The model never learnt {', '.join(strange)}: none is right there."
    return section("Confusions", element("div", answers_matrix(arrays), class_="beside"), lead=lead)


def _answers(arrays: Mapping[str, np.ndarray]) -> Markup:
    """A row a query: the answer, the runner-up, and how far the frames are from anything known."""
    actions, posterior = arrays["actions"], arrays["posterior"]
    shown = range(min(len(posterior), MOST_ROWS))
    labelled = "truth" in arrays
    rows, warn = [], {}
    for n in shown:
        order = np.argsort(-posterior[n], kind="stable")[:2]
        best = meter(float(posterior[n, order[0]]), percent(float(posterior[n, order[0]])))
        second = f"{actions[order[1]]} {percent(float(posterior[n, order[1]]))}" if len(order) > 1 else ""
        truth = [str(arrays["truth"][n])] if labelled else []
        answer, first = str(arrays["answers"][n]), str(actions[order[0]])
        named = join(answer, element("span", f"most like {first}", class_="aside")) if answer == "none" else answer
        rows.append((_query(arrays, n), *truth, named, best, second, number(float(arrays["novelty"][n]))))
        if labelled and truth[0] and str(arrays["answers"][n]) != (truth[0] if truth[0] in actions else "none"):
            warn[n] = "not the label that it has" if truth[0] in actions else "of an action that was never learnt"
    more = (
        f" The first {MOST_ROWS} of {len(posterior)}; the CSV file or ipcli info has all."
        if len(posterior) > MOST_ROWS
        else ""
    )
    columns = ("Query", *(("Label",) if labelled else ()), "Answer", "Posterior", "Next", "Novelty")
    limit = float(arrays["threshold"])
    above = f"; above {number(limit)} the answer is none" if np.isfinite(limit) else ""
    lead = "The posterior is that of the action most like it, as if one of them it must be. "
    lead += f"Novelty {OF_CLIPS if str(arrays['queries']) == 'clip' else OF_PARTS}{above}.{more}"
    return section("Answers", table(columns, rows, warn=warn), lead=lead)


def _query(arrays: Mapping[str, np.ndarray], n: int) -> Markup:
    start, end = arrays["times"][n]
    when = f"{start:.2f}–{end:.2f} s" if str(arrays["queries"]) == "window" else f"{int(arrays['frames'][n])} frames"
    return join(str(arrays["clips"][n]), element("span", when, class_="aside"))


def _groups(arrays: Mapping[str, np.ndarray]) -> Markup:
    """Which groups speak for the answer."""
    groups, shares = [str(name) for name in arrays["groups"]], arrays["group_posterior"]
    found = [n for n in range(len(shares)) if arrays["answers"][n] != "none" and np.isfinite(shares[n]).all()]
    rows = []
    for action in map(str, arrays["actions"]):
        mine = [n for n in found if arrays["answers"][n] == action]
        if mine:
            rows.append((action, len(mine), *(percent(float(share)) for share in shares[mine].mean(axis=0))))
    lead = "The posterior that each group alone gives the action that was answered, averaged over its answers."
    return section("Groups", table(("Answer", "Number", *groups), rows), lead=lead)
