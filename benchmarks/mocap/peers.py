"""Who is recognised best: behaviours against what a user might take instead, on the same splits and frames, in one run.

    python -m benchmarks.mocap.peers --name hdm05 --clips build/experiments/mocap-hdm05/all.clips.h5 \\
        --development bd,bk,dg
    python -m benchmarks.mocap.peers --name florence --clips build/experiments/mocap-florence/all.clips.h5 \\
        --published --mirror

Every method takes the setting of its declared grid that is best on the development actors (leave one out among them) or
on the development splits; all else is reported once at that setting.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import Clock, installed, isolated
from benchmarks.kit.publish import publish, say
from benchmarks.mocap.methods import METHODS, NEEDS
from benchmarks.mocap.problem import LabelledClips, loose, open_problem

HANDFULS = (20, 5, 1)  # unordered frames of a clip
SAMPLES = 3  # draws of unordered frames from each clip
WARM = 12  # clips with which a method is tried before it is timed


class SplitOfClips(NamedTuple):
    """Which clips are learnt from, and which are recognised."""

    train: np.ndarray  # (n,) bool
    test: np.ndarray


def subjects(actors: np.ndarray, known: Sequence[str]) -> SplitOfClips:
    """Some actors against all others."""
    inside = np.isin(actors, known)
    return SplitOfClips(inside, ~inside)


def leave_one_out(actors: np.ndarray) -> list[SplitOfClips]:
    """Each actor against all the others."""
    return [SplitOfClips(actors != one, actors == one) for one in np.unique(actors)]


def one_to_rest(actors: np.ndarray) -> list[SplitOfClips]:
    """All others by one actor."""
    return [SplitOfClips(test, train) for train, test in leave_one_out(actors)]


def published(splits: Sequence[np.ndarray]) -> list[SplitOfClips]:
    """Splits that came with the data: 1 to learn from, 2 to recognise."""
    return [SplitOfClips(split == 1, split == 2) for split in splits]


def protocols(
    problem: LabelledClips, development: Sequence[str], spared: int
) -> tuple[list[SplitOfClips], dict[str, list[SplitOfClips]]]:
    """The splits to choose settings on, and those to report by their names."""
    if problem.splits:
        every = published(problem.splits)
        return every[:spared], {"published": every, f"published, without the first {spared}": every[spared:]}
    inside = np.isin(problem.actors, development)
    chosen = [
        SplitOfClips(train & inside, test & inside)
        for train, test in leave_one_out(problem.actors)
        if (test & inside).any()
    ]
    return chosen, {
        "subjects": [subjects(problem.actors, development)],
        "leave-one-out": leave_one_out(problem.actors),
        "one-to-rest": one_to_rest(problem.actors),
    }


def queries(problem: LabelledClips, split: SplitOfClips, kind: str | int) -> Iterator[tuple[int, np.ndarray]]:
    """(clip, frames) of each question: whole clips, whole clips shuffled, or unordered draws of so many frames."""
    for clip in np.flatnonzero(split.test).tolist():
        rng, n = np.random.default_rng([clip, 7]), problem.lengths[clip]
        if kind == "whole":
            yield clip, np.arange(n)
        elif kind == "shuffled":
            yield clip, rng.permutation(n)
        else:
            yield from ((clip, rng.choice(n, min(int(kind), n), replace=False)) for _ in range(SAMPLES))


def measure(
    problem: LabelledClips, name: str, setting: dict[str, Any], split: SplitOfClips, kinds: Sequence[str | int]
) -> dict[str, float]:
    """Seconds to learn and to answer for the whole clips, and the share of right answers of each kind of question."""
    setting = dict(setting)
    by, mirror = setting.pop("by"), setting.pop("mirror", False)
    clips = problem.described(by, split.train)
    images = [problem.described(by, split.train, mirror=True)] if mirror else []
    method = METHODS[name][0](**setting)
    train = np.flatnonzero(split.train)
    clock = Clock()
    with clock:
        method.fit(
            [shown[i] for shown in (clips, *images) for i in train], np.tile(problem.labels[train], 1 + len(images))
        )
    found = {"train s": clock.last}
    for kind in kinds:
        asked = list(queries(problem, split, kind))
        truth = problem.labels[[clip for clip, _ in asked]]
        questions = [clips[clip] if kind == "whole" else loose(clips[clip][frames], by) for clip, frames in asked]
        with clock:
            answers = method.answer(questions)
        if kind == "whole":
            found["query s"] = clock.last
        found[str(kind)] = float(np.mean(answers == truth))
    return found | _frames(method, problem, clips, split)


def _frames(method: Any, problem: LabelledClips, clips: list[np.ndarray], split: SplitOfClips) -> dict[str, float]:
    if not hasattr(method, "frame_scores"):
        return {}
    test = np.flatnonzero(split.test)
    scores = method.frame_scores([clips[i] for i in test])
    right = [method.classes[one.argmax(axis=1)] == problem.labels[i] for one, i in zip(scores, test, strict=True)]
    return {"frames": float(np.concatenate(right).mean())}


def over(found: Sequence[dict[str, float]]) -> dict[str, Any]:
    """Mean over the splits, and where there are several the standard deviation, of what `measure` found on each."""
    table = {key: np.array([one[key] for one in found]) for key in found[0]}
    spread = {
        f"{key} sd": float(values.std(ddof=1)) for key, values in table.items() if len(found) > 1 and " s" not in key
    }
    return {key: float(values.mean()) for key, values in table.items()} | spread


def judged(
    clips: str, name: str, development: list[str], spared: int, mirror: bool = False, quick: bool = False
) -> dict[str, Any]:
    """The best setting of a method and its figures on every protocol, in this process."""
    problem = open_problem(Path(clips), published=bool(spared))
    chosen, reported = protocols(problem, development, spared)
    grid = METHODS[name][1][:1] if quick else METHODS[name][1]
    grid = tuple(setting | {"mirror": mirror} for mirror in (False, True) for setting in grid) if mirror else grid
    _warm_up(problem, name, grid[0])
    tried = [
        over([measure(problem, name, setting, split, ("whole", HANDFULS[0])) for split in chosen]) for setting in grid
    ]
    best = max(range(len(grid)), key=lambda index: (round(tried[index]["whole"], 3), tried[index][str(HANDFULS[0])]))
    found = {}  # of each split once, though it be of two protocols
    for split in (split for splits in reported.values() for split in splits):
        if id(split) not in found:
            found[id(split)] = measure(problem, name, grid[best], split, ("whole", "shuffled", *HANDFULS))
    figures = {key: over([found[id(split)] for split in splits]) for key, splits in reported.items()}
    return {"setting": grid[best], "development": tried[best], "figures": figures}


def _warm_up(problem: LabelledClips, name: str, setting: dict[str, Any]) -> None:
    """What is compiled or loaded at the first call is not counted."""
    few = np.concatenate([np.flatnonzero(problem.labels == label)[:4] for label in problem.classes[:3]])[:WARM]
    chosen = np.isin(np.arange(len(problem.labels)), few)
    measure(problem, name, setting, SplitOfClips(chosen, chosen), ("whole",))


def rows(found: dict[str, dict[str, Any]], protocol: str) -> list[dict[str, Any]]:
    """A line a method, accuracies in percent; frame and sequence accuracy are kept apart."""
    table = []
    for name, result in found.items():
        f = result["figures"][protocol]
        percent = {
            "single frames %": _told(f, "frames"),
            **{f"{size} frame{'s' * (size > 1)} of a clip %": _told(f, str(size)) for size in HANDFULS[::-1]},
            "shuffled clips %": _told(f, "shuffled"),
            "whole clips %": _told(f, "whole"),
        }
        setting = ", ".join(f"{key}={value}" for key, value in result["setting"].items())
        table.append({"method": name, **percent, "train s": f["train s"], "query s": f["query s"], "setting": setting})
    return table


def _told(figures: dict[str, float], key: str) -> str | None:
    if key not in figures:
        return None
    spread = f" ± {100 * figures[f'{key} sd']:.1f}" if f"{key} sd" in figures else ""
    return f"{100 * figures[key]:.1f}{spread}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run every method that is installed and publish a table a protocol."""
    parser = parser_of(__doc__, "each method at the first setting of its grid")
    parser.add_argument("--clips", type=Path, required=True, help="clips artefact of a data set")
    parser.add_argument("--name", default="", help="of the table; that of the clips if not given")
    parser.add_argument("--development", default="", help="actors to choose settings on, such as bd,bk,dg")
    parser.add_argument("--published", action="store_true", help="take the splits that came with the data")
    parser.add_argument(
        "--development-splits", type=int, default=3, help="of the published splits, so many to choose settings on"
    )
    parser.add_argument(
        "--mirror",
        action="store_true",
        help="let every method learn the mirror image of each clip as well, if that is better",
    )
    parser.add_argument("--methods", nargs="*", default=list(METHODS), help="only these")
    given = parser.parse_args(arguments)
    development, spared = (
        [name for name in given.development.split(",") if name],
        given.development_splits if given.published else 0,
    )
    found = {}
    for name in given.methods:
        if not installed(name, NEEDS.get(name, "sklearn")):
            continue
        say(name)
        question = {
            "clips": str(given.clips.resolve()),
            "name": name,
            "development": development,
            "spared": spared,
            "mirror": given.mirror,
            "quick": given.quick,
        }
        found[name] = isolated("benchmarks.mocap.peers:judged", 1, **question)
    stem = given.name or given.clips.name.split(".")[0]
    tables = {protocol: rows(found, protocol) for protocol in next(iter(found.values()))["figures"]}
    facts = {
        "clips": stem,
        "threads": 1,
        "settings chosen on": f"the first {spared} splits" if spared else ", ".join(development),
    }
    publish(f"mocap_peers_{stem}", f"Recognition of {stem}, ours and peers", tables, facts, given.output)


if __name__ == "__main__":
    main()
