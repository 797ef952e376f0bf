"""The options that commands share, each declared once.

`@reading`         -v -q --json --max-memory                                 for commands that only read
`@common`          these and --threads --seed --overwrite -n --executor      for commands that make artefacts
`@output(help)`     -o
`@parameters(Cls)` a flag for each `option(flag=...)` of a params dataclass, --set for the rest, --config for a file

The body of a command gets `run: Run` from the first two and `params: Cls` from the last. `progress` and `conclude` are
its voice: progress goes to stderr, results alone to stdout.
"""

from __future__ import annotations

import functools
import json
import logging
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, TextIO

import click

from ipcli.params import Leaf, Run, expected, find_config, leaves, resolve, shape
from ipcli.progress import Progress
from ipcli.stages.kit.summary import Figure

LINE_EVERY = 30.0  # seconds between lines of progress when stderr is no terminal
BAR = 40  # columns
HELP = ["-h", "--help"]  # in every command


def _set_level(ctx: click.Context, option: click.Parameter, value: int | bool) -> int | bool:
    """Eager, so that -vv also tells where a wrong option was found wrong."""
    if value:
        level = logging.ERROR if option.name == "quiet" else max(logging.DEBUG, logging.WARNING - 10 * value)
        logging.getLogger("ipcli").setLevel(level)
    return value


VERBOSE = click.option(
    "-v",
    "--verbose",
    count=True,
    is_eager=True,
    callback=_set_level,
    help="Say more; twice: all, with the traceback of an error.",
)
QUIET = click.option(
    "-q", "--quiet", is_flag=True, is_eager=True, callback=_set_level, help="Say nothing but errors; overrules -v."
)
JSON = click.option("--json", is_flag=True, help="Print one JSON object instead of text.")
THREADS = click.option(
    "--threads", type=click.IntRange(0), default=0, envvar="IPCLI_THREADS", help="Threads; 0: one a core.  [default: 0]"
)
SEED = click.option(
    "--seed", type=click.IntRange(0), default=0, envvar="IPCLI_SEED", help="Seed of all random streams.  [default: 0]"
)
OVERWRITE = click.option("--overwrite", is_flag=True, help="Make the output anew, whatever is there.")
DRY_RUN = click.option("-n", "--dry-run", is_flag=True, help="Look at the inputs, and only say what would be done.")
EXECUTOR = click.option(
    "--executor",
    default="serial",
    metavar="SPEC",
    envvar="IPCLI_EXECUTOR",
    help="Where many items run: serial, processes:N, dask or dask:ADDRESS.  [default: serial]",
)
MAX_MEMORY = click.option(
    "--max-memory",
    metavar="AMOUNT",
    envvar="IPCLI_MAX_MEMORY",
    help="Memory to keep within, such as 2GB; what is larger is cut into tiles or refused.  [default: 75%]",
)
PATH = click.Path(path_type=Path)  # type of every argument that is a file or folder
CONFIG = click.option(
    "--config",
    type=click.Path(path_type=Path),
    metavar="FILE.toml|NAME",
    help="Read parameters from a file, or from a shipped configuration by its name.",
)
SET = click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Set any parameter; may be repeated.")


def output(help: str) -> Callable:
    """-o: where the result goes. What the name may be is checked by the stage, before any work."""
    return click.option("-o", "--output", type=PATH, required=True, help=help)


def reading(command: Callable) -> Callable:
    """Options of a command that only reads."""
    return _with_run(command, (JSON, QUIET, VERBOSE, MAX_MEMORY))


def common(command: Callable) -> Callable:
    """Options of a command that makes artefacts."""
    return _with_run(command, (JSON, QUIET, VERBOSE, DRY_RUN, OVERWRITE, EXECUTOR, SEED, MAX_MEMORY, THREADS))


def _with_run(command: Callable, decorators: tuple[Callable, ...]) -> Callable:
    @functools.wraps(command)
    def body(*, verbose: int, quiet: bool, max_memory: str | None, **given: Any) -> Any:
        from ipcli import memory, threads

        names = given.keys() & Run.__dataclass_fields__.keys()
        run = Run(verbosity=-1 if quiet else verbose, **{name: given.pop(name) for name in names})
        threads.set_count(run.threads)
        memory.set_budget(max_memory)
        return command(run=run, **given)

    return functools.reduce(lambda function, decorate: decorate(function), decorators, body)


def parameters(cls: type) -> Callable[[Callable], Callable]:
    """Flags, --set and --config for a params dataclass; the body gets the resolved instance as `params`."""
    flagged = [leaf for leaf in leaves(cls) if leaf.option.flag]

    def decorate(command: Callable) -> Callable:
        @functools.wraps(command)
        def body(*, config: Path | None, sets: tuple[str, ...], **given: Any) -> Any:
            values = {leaf.key: given.pop(_variable(leaf)) for leaf in flagged}
            flags = {key: value for key, value in values.items() if value is not None}
            file = config and find_config(config, click.get_current_context().command.name or "")
            params = resolve(cls, config=file, env=os.environ, sets=sets, flags=flags)
            return command(params=params, **given)

        body.__dict__.update(parameters=cls, epilog=_epilog(cls))  # where main.load and the tests find them
        decorators = [SET, CONFIG, *(_flag(leaf) for leaf in reversed(flagged))]
        return functools.reduce(lambda function, decorate: decorate(function), decorators, body)

    return decorate


def _variable(leaf: Leaf) -> str:
    return "parameter_" + leaf.key.replace(".", "__")


def _flag(leaf: Leaf) -> Callable:
    """Text passes as it is: `resolve` reads it in the same way as --set and the environment."""
    flag = leaf.option.flag or ""  # only leaves that have one come here
    if shape(leaf.type)[0] is bool:
        name = f"{flag}/--no-{flag.removeprefix('--')}"
        return click.option(name, _variable(leaf), default=None, help=_help(leaf))
    return click.option(flag, *leaf.option.aliases, _variable(leaf), metavar=_metavar(leaf), help=_help(leaf))


def _metavar(leaf: Leaf) -> str:
    item, is_tuple, _ = shape(leaf.type)
    name = "[" + "|".join(leaf.option.choices) + "]" if leaf.option.choices else item.__name__.upper()
    return f"{name},..." if is_tuple else name


def _help(leaf: Leaf) -> str:
    about = leaf.option
    facts = [f"in {about.unit}"] if about.unit else []
    facts += [expected(leaf)] if about.flag and (about.low is not None or about.high is not None) else []
    first = about.help.split(maxsplit=1)[0]
    text = about.help if first.endswith(":") else about.help[0].upper() + about.help[1:]  # a choice stays as it is
    return f"{text}  [{'; '.join([*facts, f'default: {_shown(leaf.default)}'])}]"


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ",".join(map(str, value))
    return str(value).lower() if value is None or isinstance(value, bool) else str(value)


def _epilog(cls: type) -> str | None:
    """The parameters that have no flag; the mark in front keeps click from joining the lines."""
    rare = [leaf for leaf in leaves(cls) if not leaf.option.flag and not leaf.option.hidden]
    if not rare:
        return None
    rows = [f"  {leaf.key} ({expected(leaf)}): {_help(leaf)}" for leaf in rare]
    return "\b\nSettings for --set / TOML:\n" + "\n".join(rows)


def first_word(**words: Callable[[], click.Command]) -> type[click.Command]:
    """The class of a command whose first argument may be one of these words, each of which is a command of its own."""

    class FirstWord(click.Command):
        """A command, or the one that its first argument names."""

        def make_context(
            self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
        ) -> click.Context:
            """The context of the command that is asked for."""
            if args and args[0] in words:
                settings = {**self.context_settings, **extra}
                return words[args[0]]().make_context(f"{info_name} {args[0]}", args[1:], parent, **settings)
            return super().make_context(info_name, args, parent, **extra)

        def invoke(self, ctx: click.Context) -> Any:
            """Run the command that the context is of."""
            return super().invoke(ctx) if ctx.command is self else ctx.command.invoke(ctx)

    return FirstWord


def command(name: str, example: str = "") -> Callable[[], click.Command]:
    """What loads the command of that name when it is asked for; its help ends with the example."""

    def load() -> click.Command:
        found = import_module(f"ipcli.cli.{name.replace('-', '_')}").main
        found.context_settings = {**found.context_settings, "help_option_names": HELP}
        parts = [f"\b\nExample:\n  {example}" if example else None, getattr(found.callback, "epilog", None)]
        found.epilog = "\n\n".join(filter(None, parts)) or None
        return found

    return load


@contextmanager
def progress(label: str, run: Run) -> Iterator[Progress]:
    """A callable for stages, `tell(fraction, text)`: a bar on a terminal, else a line every 30 s; silent with -q."""
    teller = Teller(label, sys.stderr, quiet=run.verbosity < 0)
    try:
        yield teller
    finally:
        teller.close()


class Teller:
    """Progress of one job on one stream."""

    def __init__(self, label: str, stream: TextIO, *, quiet: bool = False, clock: Callable[[], float] = time.monotonic):
        self.label, self.stream, self.quiet, self.clock = label, stream, quiet, clock
        self.on_terminal = stream.isatty()
        self.told = clock()
        self.drawn = 0

    def __call__(self, fraction: float, text: str = "") -> None:
        if self.quiet:
            return
        if self.on_terminal:
            self._draw(fraction, text)
        elif self.clock() - self.told >= LINE_EVERY:
            self.told = self.clock()
            print(f"{self.label}: {fraction:.0%} {text}".rstrip(), file=self.stream, flush=True)

    def _draw(self, fraction: float, text: str) -> None:
        filled = round(BAR * min(max(fraction, 0.0), 1.0))
        line = f"{self.label} [{'#' * filled}{'.' * (BAR - filled)}] {fraction:4.0%} {text}".rstrip()
        self.stream.write("\r" + line.ljust(self.drawn))
        self.stream.flush()
        self.drawn = len(line)

    def close(self) -> None:
        """Leave the terminal on a fresh line."""
        if self.drawn:
            self.stream.write("\r" + " " * self.drawn + "\r")
            self.stream.flush()


def conclude(result: Path | Mapping[str, Any], run: Run, *, with_figures: bool = False) -> None:
    """The result on stdout: with --json one object ({"output": path} for a path), else the path, or each
    `key: value`; with `with_figures` the path and below it the others. Of a dry run, which has no result, nothing, or
    the object without figures.
    """
    facts = result if isinstance(result, Mapping) else {"output": result}
    if run.dry_run:
        facts = {key: facts[key] for key in ("output", "outputs") if key in facts} | {"dry_run": True}
    if run.json:
        click.echo(json.dumps(_jsonable(facts), allow_nan=False))
    elif run.dry_run:
        return
    elif "output" in facts:
        click.echo(str(facts["output"]))
        for key, value in facts.items():
            if with_figures and key != "output":
                click.echo(f"{key.replace('_', ' ')}: {_told(value)}")
    else:
        click.echo("\n".join(f"{key.replace('_', ' ')}: {_told(value)}" for key, value in facts.items()))


def _told(value: Any) -> str:
    """A figure in words, with four digits or more; of several by name `front 0.91, side 0.88`."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_told(item)}" for name, item in value.items())
    if isinstance(value, float):
        return f"{value:.0f}" if 1e4 <= abs(value) < 1e15 else f"{value:.4g}"
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)


def _jsonable(value: Any) -> Any:
    """Plain JSON: paths as text, numbers of numpy as Python's, NaN and infinity as null."""
    if isinstance(value, Figure):
        return _jsonable(value.value)
    if isinstance(value, Mapping):
        return {str(key): _jsonable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_jsonable(item) for item in value]
    if hasattr(value, "tolist"):
        return _jsonable(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, (str, int, float, bool)) or value is None else str(value)
