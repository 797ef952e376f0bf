"""The page of an `evaluation`: how often clips and single frames of people, clips or frames kept apart were named
right.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ipcli.report.kit import provenance as origin
from ipcli.report.kit.numbers import DASH, percent
from ipcli.report.kit.page import Markup, details, element, notice, section, table
from ipcli.report.kit.page import page as document
from ipcli.report.mocap import confusion

PROTOCOLS = {
    "subjects": "Nobody is in both parts: actors to learn from, others to be recognised.",
    "leave-one-out": "Each actor in turn is recognised by a model of all the others.",
    "one-to-rest": "A model of one actor recognises all the others, for each actor in turn.",
    "published": "The splits that came with the data.",
    "clips": "Clips at random: the same people are in both parts, so these figures do not carry over to new people.",
    "frames": "Frames at random, as in the thesis: neighbours a few milliseconds apart are in both parts, so these "
    "figures tell "
    "how well the mixtures fit, and nothing of new recordings.",
}
CONFUSIONS = "Rows are the truth, columns the answers, in percent of the row; all splits together (thesis figure 5.5)."
MOST_WRONG = 60  # rows of the table of clips that were named wrong


def page(arrays: Mapping[str, np.ndarray], provenance: Mapping[str, object], *, widest: int = 0) -> str:
    """The HTML of an `evaluation` artefact; its figures are drawn, so there is nothing for ``widest`` to bound."""
    split, splits, classes = str(arrays["split"]), arrays["splits"], _texts(arrays["classes"])
    return document(
        f"{len(classes)} actions, split by {split}",
        "ipcli mocap-evaluate",
        _verdict(arrays),
        *([notice(PROTOCOLS[split])] if split in ("frames", "clips") else []),
        _by_split(arrays),
        section("Confusions", confusions(arrays), lead=CONFUSIONS),
        _histograms(arrays, classes),
        _groups(arrays),
        clusters(arrays),
        *([_wrong(arrays, classes)] if len(splits) else []),
        origin.origin(provenance),
    )


def accuracy(confusions: np.ndarray) -> np.ndarray:
    """Share on the diagonal of each matrix (..., c, c); NaN of an empty one."""
    total = confusions.sum(axis=(-2, -1))
    with np.errstate(invalid="ignore"):
        return np.where(total > 0, np.trace(confusions, axis1=-2, axis2=-1) / np.where(total > 0, total, 1), np.nan)


def mean_and_spread(shares: np.ndarray) -> str:
    """The mean over splits, and the standard deviation between them when there are several."""
    known = shares[np.isfinite(shares)]
    if not len(known):
        return DASH
    return percent(float(known.mean())) + (f" ± {100 * known.std(ddof=1):.1f}" if len(known) > 1 else "")


def _verdict(arrays: Mapping[str, np.ndarray]) -> str:
    clips, frames = (accuracy(arrays[f"{what}_confusion"]) for what in ("sequence", "frame"))
    many = len(clips) > 1
    over = f", the mean over {len(clips)} splits and the standard deviation between them" if many else ""
    right = (
        f"{mean_and_spread(clips)} of the clips and {mean_and_spread(frames)} of the single frames were named "
        f"right{over}."
    )
    return f"{right} {PROTOCOLS.get(str(arrays['split']), '')}"


def _by_split(arrays: Mapping[str, np.ndarray]) -> Markup:
    sizes = [int(size) for size in arrays["unordered_frames"]]
    kinds = ("sequence", "frame", "pose_sequence", "unordered", "pose_frame")
    clips, frames, posed, unordered, poses = (accuracy(arrays[f"{what}_confusion"]) for what in kinds)
    shares = (clips, frames, posed, *unordered.T, poses)
    answers = (
        "Whole clips",
        "Single frames",
        "Clips by their poses",
        *(_poses(size) for size in sizes),
        "Single poses",
    )
    columns = ("Split", *answers, "Learnt from", "Recognised")
    rows = []
    for s, name in enumerate(_texts(arrays["splits"])):
        counts = (
            f"{arrays[f'{part}_clips'][s]} clips, {arrays[f'{part}_frames'][s]} frames" for part in ("train", "test")
        )
        rows.append((name, *(percent(float(share[s])) for share in shares), *counts))
    if len(rows) > 1:
        rows.append(("mean ± sd", *(mean_and_spread(share) for share in shares), "", ""))
    lead = (
        "Share of right answers to whole clips and to single frames with what moves about them; then to poses alone, "
        "in any order: all of a clip, some of a clip drawn at random, single ones."
    )
    last = {(len(rows) - 1, column) for column in range(len(columns))} if len(rows) > 1 else ()
    return section("Right answers", table(columns, rows, bold=last), lead=lead)


def _poses(size: int) -> str:
    return f"{size} poses" if size > 1 else "1 pose"


def confusions(arrays: Mapping[str, np.ndarray]) -> Markup:
    """The matrices of whole clips and of single frames side by side, all splits together."""
    classes = _texts(arrays["classes"])
    drawn = [
        confusion.matrix(arrays[f"{what}_confusion"].sum(axis=0), classes, classes, title)
        for what, title in (("sequence", "Whole clips"), ("frame", "Single frames"))
    ]
    return element("div", *drawn, class_="beside")


def histograms(counts: np.ndarray, classes: Sequence[object]) -> Markup:
    """A panel for each row of (c, c) truth by answer."""
    names = _texts(classes)
    return element(
        "div",
        *(confusion.histogram(row, names, name) for row, name in zip(counts, names, strict=True)),
        class_="panels",
    )


def _histograms(arrays: Mapping[str, np.ndarray], classes: list[str]) -> Markup:
    panels = histograms(arrays["frame_confusion"].sum(axis=0), classes)
    return section(
        "Answers to single frames",
        panels,
        lead=f"The answers to the single frames of each action (thesis figure 5.3): {bar_key(classes)}.",
    )


def bar_key(names: Sequence[object]) -> str:
    """The key to the bars of `histograms`."""
    return ", ".join(f"{index} {name}" for index, name in enumerate(names, start=1))


def _groups(arrays: Mapping[str, np.ndarray]) -> Markup:
    by_group = arrays["group_frame_accuracy"]
    rows = [(name, mean_and_spread(by_group[:, g])) for g, name in enumerate(_texts(arrays["groups"]))]
    rows.append(("all together", mean_and_spread(accuracy(arrays["frame_confusion"]))))
    lead = "Single frames named right by each group of joints alone."
    return section("Groups", table(("Group", "Single frames"), rows), lead=lead)


def clusters(arrays: Mapping[str, np.ndarray], title: str = "Behaviours") -> Markup:
    """Table 5.2: behaviours of each action and group, with the interval that holds 90 % of their posterior.

    Reads `components` (..., c, g, 3): mean, 5 % and 95 % of the number; of several splits, the means.
    """
    counts = arrays["components"].reshape(-1, *arrays["components"].shape[-3:]).mean(axis=0)
    rows = [
        (name, *(_count(*cell) for cell in line)) for name, line in zip(_texts(arrays["classes"]), counts, strict=True)
    ]
    lead = (
        "How many behaviours each action has in each group: the posterior mean, and the range that holds 90 % (thesis "
        "table 5.2)."
    )
    return section(title, table(("Action", *_texts(arrays["groups"])), rows), lead=lead)


def _count(mean: float, low: float, high: float) -> Markup:
    return element("span", f"{mean:.1f} ", element("small", f"{low:.0f}–{high:.0f}"))


def _wrong(arrays: Mapping[str, np.ndarray], classes: list[str]) -> Markup:
    truth, answer = arrays["clip_truth"], arrays["clip_answer"]
    wrong = np.flatnonzero(truth != answer)
    rows = [
        (str(arrays["clips"][n]), str(arrays["splits"][arrays["clip_split"][n]]), classes[truth[n]], classes[answer[n]])
        + (percent(float(arrays["clip_posterior"][n])),)
        for n in wrong[:MOST_WRONG]
    ]
    more = f" The first {MOST_WRONG} are shown." if len(wrong) > MOST_WRONG else ""
    lead = f"{len(wrong)} of {len(truth)} clips were named wrong.{more}"
    columns = ("Clip", "Split", "Truth", "Answer", "Posterior of the answer")
    return section("Clips named wrong", *([details("Show them", table(columns, rows))] if rows else []), lead=lead)


def _texts(values: Iterable[object]) -> list[str]:
    return [str(value) for value in values]
