"""Parameters declared once, as frozen dataclasses, feed the flags, the TOML file, the environment and the provenance.

    @dataclass(frozen=True)
    class Solver:
        iterations: int = option(300, "Most iterations.", low=1)

    @dataclass(frozen=True)
    class Fusion:
        weight: float = option(1.0, "Weight of the data.", flag="--lambda", low=0.0)
        solver: Solver = field(default_factory=Solver)

A nested dataclass is a section; its leaves are named with dots: `solver.iterations`. A value is taken from, in this
order: flag or --set, environment (IPCLI_SOLVER__ITERATIONS), TOML file, default. Standard library only, since `--help`
loads it.
"""

from __future__ import annotations

import dataclasses
import math
import os
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ipcli.errors import FormatError, ParameterError, nearest

ENVIRONMENT = "IPCLI_"
NOT_PARAMETERS = ("IPCLI_THREADS", "IPCLI_SEED", "IPCLI_EXECUTOR", "IPCLI_DATA", "IPCLI_MAX_MEMORY")
SHIPPED = Path(__file__).parent / "configs"  # COMMAND/NAME.toml
MOST_INT = (1 << 63) - 1
TRUTH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


@dataclass(frozen=True)
class Run:
    """How to run, as opposed to what to compute: only `seed` may change a result."""

    seed: int = 0
    threads: int = 0
    overwrite: bool = False
    dry_run: bool = False
    json: bool = False
    verbosity: int = 0
    executor: str = "serial"


@dataclass(frozen=True)
class Option:
    """What is known of one leaf beside its type and default. `flag` None: rare, only by --set and TOML. `aliases`:
    other spellings of the flag. `hidden`: no help tells of it, as another parameter of the command takes its place.
    """

    help: str
    flag: str | None = None
    choices: tuple[str, ...] | None = None
    low: float | None = None
    high: float | None = None
    unit: str | None = None
    aliases: tuple[str, ...] = ()
    hidden: bool = False


class Leaf(NamedTuple):
    """One parameter: dotted key, type, default and its `Option`."""

    key: str
    type: Any
    default: Any
    option: Option


def option(
    default: Any,
    help: str,
    *,
    flag: str | None = None,
    choices: Sequence[str] | None = None,
    low: float | None = None,
    high: float | None = None,
    unit: str | None = None,
    aliases: Sequence[str] = (),
) -> Any:
    """A dataclass field that is a parameter. Types: int, float, bool, str, tuple[int, ...], tuple[float, ...], X |
    None.
    """
    about = Option(help, flag, tuple(choices) if choices else None, low, high, unit, tuple(aliases))
    return dataclasses.field(default=default, metadata={"option": about})


def section(cls: type, *, without: Sequence[str]) -> Any:
    """A dataclass field that is a section of parameters, in which those of these names have no flag and no help: the
    command has others in their place.
    """
    return dataclasses.field(default_factory=cls, metadata={"without": frozenset(without)})


def leaves(cls: type) -> list[Leaf]:
    """All parameters of a dataclass in order of declaration, sections opened."""
    return list(_leaves(cls(), ""))


def _leaves(defaults: Any, prefix: str) -> Iterator[Leaf]:
    hints = typing.get_type_hints(type(defaults))
    for field in dataclasses.fields(defaults):
        key, value = prefix + field.name, getattr(defaults, field.name)
        if dataclasses.is_dataclass(value):
            hidden = {f"{key}.{name}" for name in field.metadata.get("without", ())}
            for leaf in _leaves(value, key + "."):
                about = dataclasses.replace(leaf.option, flag=None, hidden=True) if leaf.key in hidden else leaf.option
                yield leaf._replace(option=about)
        else:
            yield Leaf(key, hints[field.name], value, field.metadata["option"])


def as_dict(params: Any) -> dict[str, Any]:
    """Nested plain dict in order of declaration; tuples become lists, so that it equals its own JSON round trip."""
    values = ((field.name, getattr(params, field.name)) for field in dataclasses.fields(params))
    return {name: _plain(value) for name, value in values}


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return as_dict(value)
    return list(value) if isinstance(value, tuple) else value


def resolve(
    cls: type,
    *,
    config: Path | None = None,
    env: Mapping[str, str] | None = None,
    sets: Sequence[str] = (),
    flags: Mapping[str, Any] | None = None,
) -> Any:
    """An instance of `cls` with every value from the first source that gives it: flag = --set > env > file > default.

    Raises ParameterError for an unknown key (naming the nearest), a value of wrong type, range or choice, an unreadable
    file, or one key given two ways on the command line.
    """
    known = {leaf.key: leaf for leaf in leaves(cls)}
    values = _from_file(config, known) if config is not None else {}
    values |= _from_environment(env or {}, known)
    given = _from_sets(sets, known)
    for key, value in (flags or {}).items():
        if key in given:
            raise ParameterError(
                f"{known[key].option.flag or key} and --set {key}=... are both given; keep one of them"
            )
        given[key] = _accept(value, known[key], known[key].option.flag or key)
    return _changed(cls(), values | given, "")


def _changed(defaults: Any, values: Mapping[str, Any], prefix: str) -> Any:
    """The defaults with the values put in."""
    arguments = {}
    for field in dataclasses.fields(defaults):
        key, value = prefix + field.name, getattr(defaults, field.name)
        if dataclasses.is_dataclass(value):
            arguments[field.name] = _changed(value, values, key + ".")
        elif key in values:
            arguments[field.name] = values[key]
    return dataclasses.replace(defaults, **arguments)


def find_config(given: Path, command: str) -> Path:
    """The file of `--config`: the file of that path, or the shipped configuration NAME of `command`, or COMMAND/NAME.

    Raises ParameterError, which lists what is shipped, when a bare name is neither. Any other path is left to
    `resolve`, to read or to complain of.
    """
    if os.path.isfile(given) or given.suffix or given.is_absolute() or len(given.parts) > 2:
        return given
    shipped = {path.relative_to(SHIPPED).with_suffix("").as_posix(): path for path in SHIPPED.glob("*/*.toml")}
    found = shipped.get(given.as_posix()) or shipped.get(f"{command}/{given.as_posix()}")
    if found is None:
        own = sorted(name.rpartition("/")[2] for name in shipped if name.startswith(f"{command}/"))
        names = [*own, *sorted(name for name in shipped if not name.startswith(f"{command}/"))]
        raise ParameterError(
            f"--config {given}: no such file, nor is a configuration of that name shipped{nearest(str(given), names)} "
            f"Shipped: {', '.join(names)}"
        )
    return found


def _from_file(path: Path, known: Mapping[str, Leaf]) -> dict[str, Any]:
    from ipcli.inputs import read_toml

    try:
        entries = dict(_flatten(read_toml(path), ""))
    except FormatError as error:
        raise ParameterError(str(error)) from error
    except RecursionError as error:
        raise ParameterError(f"{path}: sections nested too deep") from error
    return {key: _accept(value, _known(key, known, str(path)), str(path)) for key, value in entries.items()}


def _flatten(tree: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _from_environment(env: Mapping[str, str], known: Mapping[str, Leaf]) -> dict[str, Any]:
    """Commands share one environment, so a name foreign to this command is only an error if it looks misspelt."""
    import difflib

    variables = {ENVIRONMENT + key.replace(".", "__").upper(): leaf for key, leaf in known.items()}
    values = {}
    for name, text in env.items():
        if not name.startswith(ENVIRONMENT) or name in NOT_PARAMETERS:
            continue
        if name in variables:
            leaf = variables[name]
            values[leaf.key] = _accept(text, leaf, f"environment variable {name}")
        elif difflib.get_close_matches(name, variables, n=1, cutoff=0.85):
            raise ParameterError(f"unknown environment variable '{name}'{nearest(name, variables)}")
    return values


def _from_sets(sets: Sequence[str], known: Mapping[str, Leaf]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for text in sets:
        key, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--set {text}: expected KEY=VALUE, such as {next(iter(known), 'key')}=...")
        if key in values:
            raise ParameterError(f"--set {key}=... is given twice; keep one of them")
        values[key] = _accept(value, _known(key, known, "--set"), "--set")
    return values


def _known(key: str, known: Mapping[str, Leaf], where: str) -> Leaf:
    if key not in known:
        raise ParameterError(f"{where}: unknown key '{key}'{nearest(key, known)}")
    return known[key]


def _accept(value: Any, leaf: Leaf, where: str) -> Any:
    """`value` (text, or a value as TOML gives it) as the type of the leaf; ParameterError if it cannot be."""
    item, is_tuple, is_optional = shape(leaf.type)
    if is_optional and (value is None or (isinstance(value, str) and value.lower() == "none")):
        return None
    try:
        if is_tuple:
            parts = value.split(",") if isinstance(value, str) else value
            return tuple(_scalar(part, item, leaf.option) for part in parts)
        return _scalar(value, item, leaf.option)
    except (TypeError, ValueError, KeyError, OverflowError):
        raise ParameterError(f"{where}: {leaf.key} = {value!r}: expected {expected(leaf)}") from None


def _scalar(value: Any, kind: Any, about: Option) -> Any:
    if isinstance(value, str) and kind is not str:
        value = TRUTH[value.lower()] if kind is bool else kind(value)
    if kind is float and type(value) is int:
        value = float(value)
    if kind is int and abs(value) > MOST_INT:  # which no array nor kernel takes
        raise ValueError
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        raise TypeError
    too_low = about.low is not None and value < about.low
    too_high = about.high is not None and value > about.high
    if too_low or too_high or (about.choices and value not in about.choices):
        raise ValueError
    return value


def shape(kind: Any) -> tuple[Any, bool, bool]:
    """(type of one value, whether it is a tuple of them, whether None is allowed) of a leaf's type."""
    is_optional = typing.get_origin(kind) in (types.UnionType, typing.Union)
    if is_optional:
        kind = next(part for part in typing.get_args(kind) if part is not types.NoneType)
    if typing.get_origin(kind) is tuple:
        return typing.get_args(kind)[0], True, is_optional
    return kind, False, is_optional


def expected(leaf: Leaf) -> str:
    """What a leaf accepts, in words: `float >= 0 or none`."""
    item, is_tuple, is_optional = shape(leaf.type)
    about = leaf.option
    words = f"one of {', '.join(about.choices)}" if about.choices else {bool: "true or false"}.get(item, item.__name__)
    if about.low is not None and about.high is not None:
        words += f" from {about.low:g} to {about.high:g}"
    elif about.low is not None or about.high is not None:
        words += f" >= {about.low:g}" if about.high is None else f" <= {about.high:g}"
    if is_tuple:
        words = f"a list of {words}, with commas"
    return words + (" or none" if is_optional else "")
