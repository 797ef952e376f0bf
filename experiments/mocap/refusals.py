"""What "none of these" was chosen by: scores, how the p-values of the folds are joined, and the default, on development
people.

    python -m experiments.mocap.refusals OUT --plain A.clips.h5 bd,bk,dg --mirrored B.clips.h5 02,05,07,08,09

Everyone is asked about in turn by what is learnt from the others, or from two or three of them, without one action or
without all but a few. The models of all but one to four people are learnt once, with all actions, so an action is left
out by leaving away its densities: the coordinates keep it, as they do not in `mocap-evaluate`. OUT.csv and OUT.json
have a row for each way to decide and each such trial, the mean over the data sets.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.kit.tables import write_table
from ipcli.inverse.bayes.parameters import Mixture
from ipcli.models.mocap import open_set, recognition
from ipcli.models.mocap.behaviours import Model
from ipcli.models.mocap.calibration import Fold, Reference, cross_conformal
from ipcli.models.mocap.motions import Motions, number_actions, of_people, with_mirror_images
from ipcli.models.mocap.novelty import SCORES, measure
from ipcli.models.mocap.parameters import Decision, Learning
from ipcli.models.mocap.training import STAGE, TrainingSet, fit_in_turn
from ipcli.rng import stream
from ipcli.stages.mocap.parameters import MocapEvaluate
from ipcli.stages.mocap.reading import read

FRAMES = 24  # of each clip, evenly spread, that are asked about
LOST = 0.03  # share of the known that may be lost
NOMINAL = (0.03, 0.05, 0.1)  # 1 - decision.reject at which what is lost is compared with it
LEVELS = np.unique(np.concatenate([NOMINAL, np.arange(0.005, 0.2, 0.005)]))
SCORE_SETS = {"without the course": SCORES[:4], "all scores": SCORES}
JOINED = {"mean of p": 1.0, "mean of their roots": 0.5, "geometric mean": 1e-3}  # by the power that is averaged
WAYS = [f"{scores}, {joined}" for scores in SCORE_SETS for joined in JOINED]
FEW_ACTIONS = 5
FEW_DRAWS = 8  # choices of so many actions
TRIALS = {
    "all others, one action left out": (None, False),
    "all others, five actions": (None, True),
    "three people, one action left out": (3, False),
    "three people, five actions": (3, True),
    "two people, one action left out": (2, False),
    "two people, five actions": (2, True),
}


@dataclass(frozen=True, eq=False)
class Development:
    """Clips of development people, and models of all but some of them, by those who were left out."""

    names: tuple[str, ...]  # of the actions
    actor: np.ndarray  # (c,), of each clip
    action: np.ndarray  # (c,) int
    query: np.ndarray  # (f,), the clip of each frame that is asked about
    models: dict[frozenset[str], tuple[Model, np.ndarray]]  # and its log densities (f, a, g)

    @classmethod
    def learn(cls, known: Motions, learning: Learning, seed: int = 0) -> Development:
        """Learn from all but one, two, ... of the people, as long as one is left."""
        names, numbers = number_actions(known.labels)
        starts = np.cumsum([0, *known.lengths])
        spread = [np.unique(np.linspace(a, b - 1, FRAMES).round().astype(int)) for a, b in itertools.pairwise(starts)]
        rows, people = np.concatenate(spread), sorted({*map(str, known.actors)})
        learnt = with_mirror_images(known) if learning.mirror else known
        models = {}
        for out in itertools.chain.from_iterable(itertools.combinations(people, n) for n in range(1, len(people))):
            kept = ~np.isin(known.actors, out)
            features = learnt.features(known.reference_lengths(np.flatnonzero(kept)), learning.features)
            own = np.resize(np.where(kept[known.clip], numbers, -1), len(learnt.clip))
            rng = stream(seed, STAGE, f"frames without {' '.join(out)}")
            training = TrainingSet.draw(features, own, names, learning, rng)
            model = training.model(fit_in_turn(training.points, learning, seed))
            density = recognition.log_densities(model, {group: x[rows] for group, x in features.items()})
            models[frozenset(out)] = model, density
            print(f"learnt without {', '.join(out)}", flush=True)
        return cls(names, known.actors, numbers[starts[:-1]], known.clip[rows], models)

    @property
    def people(self) -> list[str]:
        """Everyone, in order."""
        return sorted({*map(str, self.actor)})

    def fold(self, out: Sequence[str], who: str, actions: Sequence[int]) -> Fold:
        """What the model without some people says of the clips of one of them, knowing these actions alone; the others
        have the action -1.
        """
        model, density = self.models[frozenset(out)]
        told = replace(
            model,
            actions=tuple(model.actions[a] for a in actions),
            predictives=tuple(model.predictives[a] for a in actions),
            alpha=model.alpha[list(actions)],
        )
        mine = self.actor[self.query] == who
        clips, query = np.unique(self.query[mine], return_inverse=True)
        number = np.full(len(self.names), -1)
        number[list(actions)] = np.arange(len(actions))
        return Fold(told, density[mine][:, list(actions)], query, number[self.action[clips]])


def known_actions(fold: Fold) -> Fold:
    """The clips of a fold whose action is known."""
    kept = fold.action >= 0
    rows = kept[fold.query]
    query = (np.cumsum(kept) - 1)[fold.query[rows]]
    return replace(fold, log_density=fold.log_density[rows], query=query, action=fold.action[kept])


def questions(data: Development, learnt_from: int | None, few: bool) -> Iterator[tuple[str, list[str], list[int]]]:
    """Who is asked about, the people who are learnt from and the actions."""
    count, rng = len(data.names), stream(0, "refusals", "actions")
    chosen = [[a for a in range(count) if a != out] for out in range(count)]
    if few:
        chosen = [sorted(rng.permutation(count)[:FEW_ACTIONS].tolist()) for _ in range(FEW_DRAWS)]
    for who in data.people:
        others = [one for one in data.people if one != who]
        for some in itertools.combinations(others, learnt_from or len(others)):
            for actions in chosen if learnt_from is None else chosen[::2]:
                yield who, list(some), actions


def outcomes(
    data: Development, learnt_from: int | None, few: bool, decision: Decision
) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """p-values of known and unknown clips by each of WAYS, a pair for each question with both."""
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {way: [] for way in WAYS}
    for who, people, actions in questions(data, learnt_from, few):
        away = [one for one in data.people if one not in people]
        folds = [known_actions(data.fold([*away, one], one, actions)) for one in people]
        asked = [data.fold([*away, one], who, actions) for one in people]
        is_known = asked[0].action >= 0
        reference = Reference.of_folds(folds, decision, ordered=True)
        if reference is None or is_known.all() or not is_known.any():
            continue
        measured = [
            measure(one.model, one.log_density, one.query, len(one.action), decision, ordered=True) for one in asked
        ]
        for name, scores in SCORE_SETS.items():
            compared = reference.compared(measured, scores)
            for joined, power in JOINED.items():
                p_value = 10 ** -cross_conformal(*compared, power)
                found[f"{name}, {joined}"].append((p_value[is_known], p_value[~is_known]))
    return found


def summary(sets: Sequence[Sequence[tuple[np.ndarray, np.ndarray]]]) -> dict[str, float]:
    """Figures of one way in one trial, in percent, from the pairs of p-values of each data set; each set counts the
    same.
    """
    curves = np.array(
        [np.mean([[(p[:, None] < LEVELS).mean(axis=0) for p in pair] for pair in pairs], axis=0) for pairs in sets]
    )  # (sets, known or unknown, levels)
    lost, caught = curves.mean(axis=0)
    level = float(np.interp(LOST, lost, LEVELS))
    areas = [np.mean([open_set.area(-known, -unknown) for known, unknown in pairs]) for pairs in sets]
    losses = {f"lost at {n:g}": round(100 * float(np.interp(n, LEVELS, lost)), 1) for n in NOMINAL}
    return {
        "area": round(float(np.mean(areas)), 3),
        **losses,
        "caught at 0.05": round(100 * float(np.interp(0.05, LEVELS, caught)), 1),
        f"caught where {LOST:.0%} lost": round(100 * float(np.interp(level, LEVELS, caught)), 1),
        "reject there": round(1 - level, 3),
    }


def rows_of(data: Sequence[Development], decision: Decision) -> list[dict[str, object]]:
    """A row for each trial and way, and for each way the mean over the trials with the mean error of what is lost."""
    rows: list[dict[str, object]] = []
    for trial, (learnt_from, few) in TRIALS.items():
        able = [one for one in data if learnt_from is None or len(one.people) - 1 > learnt_from]
        found = [outcomes(one, learnt_from, few, decision) for one in able]
        rows += [
            {"trial": trial, "way": way, **summary([one[way] for one in found])} for way in WAYS if all_told(found)
        ]
    for way in WAYS:
        mine = [row for row in rows if row["way"] == way]
        means = {key: np.mean([float(str(row[key])) for row in mine]) for key in mine[0] if key not in ("trial", "way")}
        rows.append({"trial": "mean", "way": way, **{key: round(float(x), 3) for key, x in means.items()}})
    return rows


def all_told(found: Sequence[dict[str, list[tuple[np.ndarray, np.ndarray]]]]) -> bool:
    """Whether there is a data set, and something of each."""
    return bool(found) and all(pairs for one in found for pairs in one.values())


def main(arguments: Sequence[str] | None = None) -> None:
    """Learn, ask and leave the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="of the table, without suffix")
    for option, how in (("--plain", "as they are"), ("--mirrored", "with their mirror images")):
        text = f"clips to learn {how}, and their development people: bd,bk,dg"
        parser.add_argument(option, nargs=2, action="append", default=[], metavar=("CLIPS", "PEOPLE"), help=text)
    parser.add_argument("--sweeps", type=int, default=16, help="of the sampler, half of them burn-in")
    given = parser.parse_args(arguments)
    defaults, mixture = MocapEvaluate(), Mixture(sweeps=given.sweeps, burn_in=given.sweeps // 2)
    data = []
    for mirror, sets in ((False, given.plain), (True, given.mirrored)):
        learning = replace(Learning(), frames=Learning().fold_frames, mirror=mirror, mixture=mixture)
        for path, people in sets:
            known = of_people(read([Path(path)], defaults.reading, defaults.groups), people.split(","))
            data.append(Development.learn(known, learning))
    rows = rows_of(data, Decision())
    write_table(given.out, rows, sets=[[*map(str, one)] for one in (*given.plain, *given.mirrored)])
    for row in rows:
        print("  ".join(f"{value}" for value in row.values()))


if __name__ == "__main__":
    main()
