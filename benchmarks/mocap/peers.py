"""Who is recognised best: behaviours against what a user might take instead, on the same splits and frames, in one run.

    python -m benchmarks.mocap.peers --name hdm05 --clips build/experiments/mocap-hdm05/all.clips.h5 \\
        --development bd,bk,dg
    python -m benchmarks.mocap.peers --name florence --clips build/experiments/mocap-florence/all.clips.h5 \\
        --published --mirror

Ours is at its defaults. Every peer takes the setting of its declared grid that is best on the development actors (leave
one out among them) or on the development splits; all else is reported once at that setting. What was measured of a
split is kept in a file beside the tables, NAME.kept.jsonl, so that a run that was killed goes on where it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.kit.arguments import parser_of
from benchmarks.kit.measure import Clock, installed, isolated
from benchmarks.kit.memory import Memory
from benchmarks.kit.publish import publish, say
from benchmarks.mocap.methods import METHODS, NEEDS, ORDERED
from benchmarks.mocap.problem import LabelledClips, loose, open_problem
from ipcli.inverse.bayes.mixture import Fitted
from ipcli.models.mocap.evaluation import evaluate, make_splits
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.splits import Split
from ipcli.models.mocap.training import fit_in_turn
from ipcli.provenance import sha256

OURS = "behaviours (ours)"
SEED = 0  # that of the commands
HANDFULS = (20, 5, 1)  # unordered frames of a clip
SAMPLES = 3  # draws of unordered frames from each clip
WARM = 12  # clips with which a method is tried before it is timed


def protocols(
    problem: LabelledClips, development: Sequence[str], spared: int
) -> tuple[list[Split], dict[str, list[Split]]]:
    """The splits to choose settings on, and those to report by their names: published ones, of which the first so many
    are spared, or else by people, of whom some are for development.
    """
    if spared:
        every = make_splits(problem.motions, "published", SEED)
        return every[:spared], {"published": every, f"published, without the first {spared}": every[spared:]}
    others = [name for name in np.unique(problem.actors) if name not in development]
    reported = {
        kind: make_splits(problem.motions, kind, SEED, test=others)
        for kind in ("subjects", "leave-one-out", "one-to-rest")
    }
    inside = np.isin(problem.actors, development)[problem.motions.clip]
    chosen = [
        replace(split, name=f"{split.name} of {', '.join(development)}", train=split.train & inside)
        for split in reported["leave-one-out"]
        if (split.test & inside).any()
    ]
    return chosen, reported


def queries(problem: LabelledClips, split: Split, kind: str | int) -> Iterator[tuple[int, np.ndarray]]:
    """(clip, frames) of each question: whole clips, whole clips shuffled, or unordered draws of so many frames."""
    for clip in problem.those_of(split.test).tolist():
        rng, n = np.random.default_rng([clip, 7]), problem.lengths[clip]
        if kind == "whole":
            yield clip, np.arange(n)
        elif kind == "shuffled":
            yield clip, rng.permutation(n)
        else:
            yield from ((clip, rng.choice(n, min(int(kind), n), replace=False)) for _ in range(SAMPLES))


def measure(
    problem: LabelledClips, name: str, setting: dict[str, Any], split: Split, kinds: Sequence[str | int]
) -> dict[str, float]:
    """Seconds to learn and to answer for the whole clips, and the share of right answers of each kind of question; of
    OURS what it is at its defaults.
    """
    if name == OURS:
        return measure_ours(problem, setting["mirror"], split)
    setting = dict(setting)
    by, mirror = setting.pop("by"), setting.pop("mirror", False)
    train, test = problem.those_of(split.train), problem.those_of(split.test)
    clips = problem.described(by, train)
    images = [problem.described(by, train, mirror=True)] if mirror else []
    method = METHODS[name][0](**setting)
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
    return found | _frames(method, problem, [clips[i] for i in test], test)


def _frames(method: Any, problem: LabelledClips, clips: list[np.ndarray], test: np.ndarray) -> dict[str, float]:
    if not hasattr(method, "frame_scores"):
        return {}
    scores = method.frame_scores(clips)
    right = [method.classes[one.argmax(axis=1)] == problem.labels[i] for one, i in zip(scores, test, strict=True)]
    return {"frames": float(np.concatenate(right).mean())}


def measure_ours(problem: LabelledClips, mirror: bool, split: Split) -> dict[str, float]:
    """The same of ours, by the function of mocap-evaluate with its defaults and seed: what the command answers.

    Shuffled clips are answered by their poses alone, unordered frames by its own draws of them.
    """
    learning, learns, works = Learning(mirror=mirror), Clock(), Clock()

    def fit(points: Mapping[str, np.ndarray]) -> dict[str, Fitted]:
        with learns:
            return fit_in_turn(points, learning, SEED)

    with works:
        told = evaluate(
            problem.motions, [split], learning, Decision(), SEED, unordered=HANDFULS, draws=SAMPLES, fit=fit
        )
    tables = {
        "frames": told["frame_confusion"][0],
        "whole": told["sequence_confusion"][0],
        "shuffled": told["pose_sequence_confusion"][0],
    } | dict(zip(map(str, HANDFULS), told["unordered_confusion"][0], strict=True))
    right = {kind: float(table.trace() / table.sum()) for kind, table in tables.items()}
    return {"train s": learns.last, "query s": works.last - learns.last} | right


def over(found: Sequence[dict[str, float]]) -> dict[str, Any]:
    """Mean over the splits, and where there are several the standard deviation, of what `measure` found on each."""
    table = {key: np.array([one[key] for one in found]) for key in found[0]}
    spread = {
        f"{key} sd": float(values.std(ddof=1)) for key, values in table.items() if len(found) > 1 and " s" not in key
    }
    return {key: float(values.mean()) for key, values in table.items()} | spread


def judged(
    clips: str, name: str, development: list[str], spared: int, kept: str, mirror: bool = False, quick: bool = False
) -> dict[str, Any]:
    """The best setting of a method and its figures on every protocol, in this process; what the file `kept` holds is
    not measured again.
    """
    problem, memory, source = open_problem(Path(clips)), Memory(Path(kept)), sha256(Path(clips))
    chosen, reported = protocols(problem, development, spared)

    def found(setting: dict[str, Any], split: Split, kinds: Sequence[str | int]) -> dict[str, float]:
        key = [source, name, setting, split.name, *kinds]
        return memory.recall(key, lambda: measure(problem, name, setting, split, kinds))

    grid = settings(name, mirror, quick)
    if name != OURS:  # which learns for longer than it compiles
        _warm_up(problem, name, grid[0])
    tried = [[found(setting, split, ("whole",)) for setting in grid] for split in chosen] if len(grid) > 1 else []
    development_figures = [over(one) for one in zip(*tried, strict=True)]
    best = max(range(len(development_figures)), key=lambda index: _standing(development_figures[index]), default=0)
    kinds = ("whole",) if name in ORDERED else ("whole", "shuffled", *HANDFULS)
    by_split = {split.name: found(grid[best], split, kinds) for splits in reported.values() for split in splits}
    return {
        "setting": grid[best],
        "figures": {key: over([by_split[one.name] for one in splits]) for key, splits in reported.items()},
        "splits": {key: {one.name: by_split[one.name]["whole"] for one in splits} for key, splits in reported.items()},
    }


def settings(name: str, mirror: bool, quick: bool) -> list[dict[str, Any]]:
    """What is tried of a method: its grid, with `mirror` of both learning and not learning mirror images. Ours is at
    its defaults.
    """
    if name == OURS:
        return [{"mirror": mirror}]
    grid = METHODS[name][1][:1] if quick else METHODS[name][1]
    return [setting | {"mirror": image} for image in ((False, True) if mirror else (False,)) for setting in grid]


def _standing(figures: dict[str, float]) -> tuple[float, float]:
    """Whole clips count, and where they are even single frames, of methods that name them."""
    return round(figures["whole"], 3), figures.get("frames", 0.0)


def _warm_up(problem: LabelledClips, name: str, setting: dict[str, Any]) -> None:
    """What is compiled or loaded at the first call is not counted."""
    few = np.concatenate([np.flatnonzero(problem.labels == label)[:4] for label in problem.classes[:3]])[:WARM]
    rows = np.isin(problem.motions.clip, few)
    measure(problem, name, setting, Split("warm", rows, rows), ("whole",))


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


def split_rows(found: dict[str, dict[str, Any]], protocol: str) -> list[dict[str, Any]]:
    """A line a method: whole clips of each split, in percent."""
    return [
        {"method": name} | {split: f"{100 * share:.1f}" for split, share in result["splits"][protocol].items()}
        for name, result in found.items()
    ]


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
    parser.add_argument("--methods", nargs="*", default=[OURS, *METHODS], help="only these")
    given = parser.parse_args(arguments)
    development, spared = (
        [name for name in given.development.split(",") if name],
        given.development_splits if given.published else 0,
    )
    stem = given.name or given.clips.name.split(".")[0]
    kept = given.output / f"mocap_peers_{stem}.kept.jsonl"
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
            "kept": str(kept.resolve()),
            "mirror": given.mirror,
            "quick": given.quick,
        }
        found[name] = isolated("benchmarks.mocap.peers:judged", 1, **question)
    splits = next(iter(found.values()))["splits"]
    tables = {protocol: rows(found, protocol) for protocol in splits} | {
        f"{protocol}, whole clips of each split %": split_rows(found, protocol)
        for protocol, names in splits.items()
        if len(names) > 1
    }
    facts = {
        "clips": stem,
        "threads": 1,
        "settings chosen on": f"the first {spared} splits" if spared else ", ".join(development),
    }
    publish(f"mocap_peers_{stem}", f"Recognition of {stem}, ours and peers", tables, facts, given.output)


if __name__ == "__main__":
    main()
