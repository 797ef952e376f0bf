"""What can be chosen for each mocap command, declared once for flags, configuration files and provenance.

Standard library only: all that a command's --help loads.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ipcli.models.mocap.parameters import LEFT_OUT, SPLIT_KINDS, Decision, Learning
from ipcli.params import option


@dataclass(frozen=True)
class ClipSource:
    """What motion files do not say; each is refused where the format has no use for it, and None leaves the format's
    own default.
    """

    format: str = option("auto", "Layout: auto, clips, florence3d, utkinect or files.", flag="--format")
    unit: str | None = option(
        None, "Unit of length of the files: m, cm, mm, inch, or metres as a number.", flag="--unit"
    )
    up: str | None = option(
        None, "Axis of the files that points up.", flag="--up", choices=("x", "y", "z", "-x", "-y", "-z")
    )
    source_rate: float | None = option(
        None, "Rate of files that do not say it.", flag="--source-rate", low=0.0, unit="Hz"
    )
    manifest: str | None = option(None, "CSV file: path,label,actor[,start,stop,name,split].", flag="--manifest")


@dataclass(frozen=True)
class ClipReading:
    """How the commands that learn and recognise read clips."""

    rate: float = option(30.0, "rate to bring all clips to", flag="--rate", low=1.0, high=1000.0, unit="Hz")
    source: ClipSource = field(default_factory=ClipSource)


@dataclass(frozen=True)
class ImportClips:
    """Which clips to import, and at what rate."""

    rate: float | None = option(None, "Rate to bring all clips to.", flag="--rate", low=1.0, high=1000.0, unit="Hz")
    labels: str | None = option(None, "Actions to take, with commas, by their names in the source.", flag="--labels")
    rename: str | None = option(
        None, "Other names of actions: OLD=NEW with commas; one NEW for several joins them.", flag="--rename"
    )
    source: ClipSource = field(default_factory=ClipSource)


@dataclass(frozen=True)
class MocapTrain:
    """What to learn from and how."""

    groups: str = option("auto", "groups of joints: auto, the name of shipped ones, or a TOML file", flag="--groups")
    actors: tuple[str, ...] = option(
        (), "learn only from these people, with commas; none given: from all", flag="--actors"
    )
    actions: tuple[str, ...] = option((), "learn only these actions, with commas; none given: all", flag="--actions")
    reading: ClipReading = field(default_factory=ClipReading)
    learning: Learning = field(default_factory=Learning)
    decision: Decision = field(default_factory=Decision)


@dataclass(frozen=True)
class MocapClassify:
    """What is asked about, and how the answers of frames and groups make one."""

    actors: tuple[str, ...] = option(
        (), "ask about clips of these people only, with commas; none given: of all", flag="--actors"
    )
    unordered: int = option(
        0,
        "ask about so many frames of each clip, drawn at random, by their poses alone; 0: about all",
        flag="--unordered",
        low=0,
    )
    draws: int = option(1, "so many draws of unordered frames from each clip", flag="--draws", low=1)
    window: float | None = option(
        None, "ask about a window of that length along each clip", flag="--window", low=0.0, unit="s"
    )
    step: float | None = option(
        None, "from one window to the next; a quarter of the window if not given", flag="--step", low=0.0, unit="s"
    )
    motion: bool = option(
        True, "use how the parts move, where the model knows; else poses alone, in any order", flag="--motion"
    )
    none: bool = option(True, "allow the answer that it is none of the actions", flag="--none")
    least: float = option(
        0.0,
        "least posterior of an answer, below which it is none: of clips, and of windows where an action changes",
        flag="--least",
        low=0.0,
        high=1.0,
    )
    reading: ClipReading = field(default_factory=ClipReading)
    decision: Decision = field(default_factory=Decision)


@dataclass(frozen=True)
class MocapEvaluate:
    """How the clips are split, and how is learnt and recognised."""

    split: str = option(
        "subjects",
        "how to split the clips: by subjects, at random by clips or frames, ...; leave-actions-out: by subjects (or "
        "the published split --only names), each action left out in turn, to tell how often none of these is right",
        flag="--split",
        choices=(*SPLIT_KINDS, LEFT_OUT),
    )
    test: tuple[str, ...] = option(
        (), "people to recognise with --split subjects or leave-actions-out; none given: every other one", flag="--test"
    )
    only: tuple[str, ...] = option(
        (), "of the published splits, only these, with commas; none given: all", flag="--only"
    )
    actors: tuple[str, ...] = option(
        (), "take clips of these people only, with commas; none given: of all", flag="--actors"
    )
    actions: tuple[str, ...] = option((), "take these actions only, with commas; none given: all", flag="--actions")
    repeats: int = option(1, "random splits by clips or frames, each drawn anew", flag="--repeats", low=1)
    unordered: tuple[int, ...] = option(
        (20, 5, 1), "numbers of unordered frames of a clip to ask about together", flag="--unordered", low=1
    )
    draws: int = option(3, "draws of unordered frames of each number from each clip", low=1)
    groups: str = option("auto", "groups of joints: auto, the name of shipped ones, or a TOML file", flag="--groups")
    reading: ClipReading = field(default_factory=ClipReading)
    learning: Learning = field(default_factory=Learning)
    decision: Decision = field(default_factory=Decision)
