"""The page of an experiment of chapter 5: right answers beside what they are held to, beside peers, and beside what the
thesis prints.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from experiments.kit.bars import Bar, Standing, bars_section
from experiments.kit.credits import Credit, credits_section
from experiments.kit.printed import Printed
from experiments.kit.run import page_of
from ipcli.report.kit.numbers import DASH, number, percent
from ipcli.report.kit.page import Markup, details, element, section, table
from ipcli.report.kit.skeleton import bounds
from ipcli.report.mocap import action_evaluation, behaviours
from ipcli.report.mocap.action_evaluation import accuracy, clusters, confusions, histograms, mean_and_spread

FRAMES, CLIPS = "frames", "clips"  # queries: single frames, whole clips; unordered frames by their number
POSE, POSES = "pose", "poses"  # the same without what moves: a single pose, the poses of a clip in any order
CONFUSIONS = {
    FRAMES: "frame_confusion",
    POSE: "pose_frame_confusion",
    POSES: "pose_sequence_confusion",
    CLIPS: "sequence_confusion",
}
WORDS = {
    "subjects": "some people to the others",
    "leave-one-out": "all but one to that one",
    "one-to-rest": "one to all others",
    "published": "published: half of the people to the others",
    "clips": "random clips: the same people on both sides",
    "frames": "random frames, as in the thesis: neighbours on both sides",
}
SHOWN = 6  # behaviours of an action that are drawn
Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class RecognitionExperiment:
    """All that a page shows. Evaluations by method and split; the first method is what a user gets who chooses
    nothing.
    """

    title: str
    lead: str
    evaluations: Mapping[tuple[str, str], Arrays]
    model: Arrays | None = None
    bars: Sequence[Bar] = ()
    printed: Mapping[str, Printed] = field(default_factory=dict)
    peers: Mapping[str, Sequence[Mapping[str, object]]] = field(default_factory=dict)
    credits: Sequence[Credit] = ()

    @property
    def methods(self) -> list[str]:
        """In order, the default first."""
        return list(dict.fromkeys(method for method, _ in self.evaluations))

    @property
    def splits(self) -> list[str]:
        """In the order of WORDS: from the hardest to the easiest."""
        return sorted({split for _, split in self.evaluations}, key=list(WORDS).index)

    @property
    def sizes(self) -> list[int]:
        """Numbers of unordered frames, the smallest first; those that all evaluations have."""
        every = [set(map(int, one["unordered_frames"])) for one in self.evaluations.values()]
        return sorted(set.intersection(*every)) if every else []

    @property
    def queries(self) -> list[str]:
        """Single frames, single poses, unordered frames, clips of poses in any order, whole clips."""
        return [FRAMES, POSE, *map(str, self.sizes), POSES, CLIPS]

    def shares(self, method: str, split: str, query: str) -> np.ndarray:
        """Share of right answers in each split (s,); empty for what was not run."""
        found = self.evaluations.get((method, split))
        if found is None:
            return np.empty(0)
        if query in CONFUSIONS:
            return accuracy(found[CONFUSIONS[query]])
        return accuracy(
            found["unordered_confusion"][:, [int(size) for size in found["unordered_frames"]].index(int(query))]
        )

    def percent(self, method: str, split: str, query: str) -> float:
        """Mean over the splits, of 100; NaN for what was not run."""
        known = self.shares(method, split, query)
        return 100 * float(np.nanmean(known)) if np.isfinite(known).any() else float("nan")

    def peer(self, name: str, split: str, query: str) -> float:
        """What a peer reached; NaN where it was not run."""
        found = next((row.get(heading(query)) for row in self.peers.get(split, ()) if row["method"] == name), None)
        return float(str(found).split()[0]) if found is not None else float("nan")


def heading(query: str) -> str:
    """The column of a query in the tables of peers."""
    many = {
        POSE: "single frames %",
        FRAMES: "single frames %",
        POSES: "whole clips %",
        CLIPS: "whole clips %",
        "1": "1 frame of a clip %",
    }
    return many.get(query, f"{query} frames of a clip %")


def page(experiment: RecognitionExperiment) -> str:
    """The whole page."""
    e = experiment
    parts = [
        _held_to(e),
        _table(e),
        *_peers(e),
        *_table_5_1(e),
        *_answers(e),
        *_confusions(e),
        *_clusters(e),
        *_poses(e),
        _links(e),
        credits_section(e.credits),
    ]
    return page_of("mocap", e.title, e.lead, *parts)


def _held_to(e: RecognitionExperiment) -> Markup | None:
    """What was to be reached, and what was."""
    standings = [_standing(e, bar) for bar in e.bars]
    heads, lead = ("", "asked about"), "Right answers, the mean over splits."
    return bars_section(standings, e.methods[0], heads, least=False, unit="%", lead=lead)


def _standing(e: RecognitionExperiment, bar: Bar) -> Standing:
    """The measure is a split and a query; a bar that is a name is that peer's figure."""
    split, query = bar.measure
    asked = e.peer(bar.bar, split, query) if isinstance(bar.bar, str) else bar.bar
    reached = {method: e.percent(method, split, query) for method in e.methods if (method, split) in e.evaluations}
    return Standing(bar, (WORDS[split], _asked(query)), asked, reached)


def _asked(query: str) -> str:
    words = {
        FRAMES: "single frames",
        POSE: "single poses",
        POSES: "whole clips, poses in any order",
        CLIPS: "whole clips",
        "1": "1 pose of each clip",
    }
    return words.get(query, f"{query} poses of each clip, in no order")


def _table(e: RecognitionExperiment) -> Markup:
    rows = []
    for split in e.splits:
        run = [method for method in e.methods if (method, split) in e.evaluations]
        for index, method in enumerate(run):
            rows.append(
                (
                    WORDS[split] if not index else "",
                    method,
                    *(mean_and_spread(e.shares(method, split, query)) for query in e.queries),
                )
            )
    lead = (
        "Right answers to single frames and to whole clips, and to the same from poses alone, in any order; the mean "
        "over splits and the "
        "standard deviation between them. Frames at random say how well the mixtures fit, and nothing of new "
        "recordings."
    )
    sizes = (f"{size} pose{'s' * (size > 1)} of a clip" for size in e.sizes)
    heads = (
        "from whom to whom",
        "method",
        "single frames",
        "single poses",
        *sizes,
        "clips by their poses",
        "whole clips",
    )
    return section("Right answers", table(heads, rows), lead=lead)


def _peers(e: RecognitionExperiment) -> Iterator[Markup]:
    """The tables of the benchmark, where it was run."""
    blocks = []
    for split, rows in e.peers.items():
        columns = list(dict.fromkeys(key for row in rows for key in row))
        cells = [[_plain(row.get(column)) for column in columns] for row in rows]
        blocks += [element("h3", WORDS.get(split, split)), element("div", table(columns, cells), class_="dense")]
    if blocks:
        lead = (
            "benchmarks/mocap/peers.py: the same clips and splits, ours at its defaults and each other method at the "
            "best setting of its declared grid on development data. "
            "Shuffled clips: all frames of a clip in random order."
        )
        yield section("Beside others", *blocks, lead=lead)


def _plain(value: object) -> str:
    return DASH if value is None else number(value) if isinstance(value, float) else str(value)


def _table_5_1(e: RecognitionExperiment) -> Iterator[Markup]:
    """The accuracies that the thesis prints, ours below, never frames beside clips."""
    if "5.1" not in e.printed:
        return
    printed = e.printed["5.1"]
    rows = [(f"thesis: {row[0]}", "", *(cell or DASH for cell in row[1:])) for row in printed.rows]
    for split in e.splits[::-1]:
        for method in (name for name in e.methods if (name, split) in e.evaluations):
            figures = (number(e.percent(method, split, query)) for query in (FRAMES, CLIPS))
            rows.append((f"ours: {method}", WORDS[split], *figures))
    lead = (
        "The thesis sets frames of one method beside sequences of the other. Five of its eleven actions are among "
        "those here; the others "
        "are not to be had, so compare with its random frames only in kind. DMW has no public code."
    )
    shown = table(("", "from whom to whom", *printed.columns[1:]), rows)
    yield section(f"Beside {printed.number.lower()}", shown, lead=f"{printed.words}. {lead}")


def _answers(e: RecognitionExperiment) -> Iterator[Markup]:
    """Figures 5.3 and 5.4: what was answered to frames, and to some of them in no order."""
    for split in [name for name in ("frames", "subjects", "published") if (e.methods[0], name) in e.evaluations]:
        own = e.evaluations[e.methods[0], split]
        few = own["unordered_confusion"][:, int(np.argmax(own["unordered_frames"]))].sum(axis=0)
        parts = [
            element("h3", "Single frames (thesis figure 5.3)"),
            histograms(own["frame_confusion"].sum(axis=0), list(own["classes"])),
            element(
                "h3", f"{own['unordered_frames'].max()} poses of a clip, in no order (in place of thesis figure 5.4)"
            ),
            histograms(few, list(own["classes"])),
        ]
        yield section(
            f"Answers: {WORDS[split]}",
            *parts,
            lead=f"The answers to each action: {action_evaluation.bar_key(list(own['classes']))}.",
        )


def _confusions(e: RecognitionExperiment) -> Iterator[Markup]:
    """Figure 5.5."""
    blocks: list[Markup] = []
    for split in e.splits:
        for method in e.methods:
            if (method, split) in e.evaluations:
                drawn = confusions(e.evaluations[method, split])
                blocks.append(drawn if not blocks else details(f"{WORDS[split]}; {method}", drawn))
    lead = (
        f"Rows are the truth, columns the answers, in percent of the row. First: {WORDS[e.splits[0]]}, {e.methods[0]}."
    )
    yield section("Confusions (thesis figure 5.5)", *blocks, lead=lead)


def _clusters(e: RecognitionExperiment) -> Iterator[Markup]:
    """Table 5.2: printed and ours, of the thesis' own features; of ours below."""
    printed = e.printed.get("5.2")
    if printed is None:
        return
    shown = table(printed.columns, [[cell or DASH for cell in row] for row in printed.rows])
    yield section(printed.number, shown, lead=printed.words)
    for method in ("thesis", e.methods[0]):
        if (found := e.evaluations.get((method, "frames"))) is not None:
            yield clusters(found, f"Behaviours: {method}")


def _poses(e: RecognitionExperiment) -> Iterator[Markup]:
    """Figure 5.6: of each action the group that counts most, its most frequent behaviours."""
    if e.model is None:
        return
    box, parts = bounds([e.model["behaviour_poses"]]), []
    for action, name in enumerate(map(str, e.model["actions"])):
        parted = [str(group) not in ("body", "motion") for group in e.model["groups"]]
        group = int(np.argmax(np.where(parted, e.model["preferences"][action], 0)))
        title = (
            f"{name}: {e.model['groups'][group]}, {percent(float(e.model['preferences'][action, group]))} of the "
            "preferences"
        )
        parts += [element("h3", title), behaviours.behaviours(e.model, action, group, box, SHOWN)]
    lead = (
        "Each by its most typical frame, from the front and from the right, the other frames faint; of each action "
        "the part of the body that counts most."
    )
    yield section("Behaviours (thesis figure 5.6)", *parts, lead=lead)


def _links(e: RecognitionExperiment) -> Markup:
    names = [(method, split, f"{method}-{split}.evaluation.html") for method, split in e.evaluations]
    links = [element("a", f"{method}: {WORDS[split]}", href=href) for method, split, href in names]
    links += (
        [element("a", "the behaviours of all actions and groups", href="all.model.html")] if e.model is not None else []
    )
    return section(
        "More", *(element("p", link) for link in links), lead="A page each, with all clips that were named wrong."
    )
