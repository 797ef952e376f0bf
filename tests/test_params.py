"""Where a parameter's value comes from, and what is refused."""

import itertools
import json
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli import params
from ipcli.errors import ParameterError
from ipcli.params import option


@dataclass(frozen=True)
class Solver:
    iterations: int = option(300, "Most iterations.", low=1, high=10_000)
    restart: bool = option(True, "Restart.")


@dataclass(frozen=True)
class Example:
    weight: float = option(1.0, "Weight.", flag="--lambda", low=0.0)
    method: str = option("acs", "Method.", flag="--method", choices=("acs", "ama"))
    reference: str | None = option(None, "View.", flag="--reference")
    alphas: tuple[float, ...] = option((1.0, 2.0), "Weights.", low=0.0)
    levels: tuple[int, ...] | None = option(None, "Levels.")
    solver: Solver = field(default_factory=Solver)


@dataclass(frozen=True)
class Longer:
    solver: Solver = field(default_factory=lambda: Solver(iterations=700))


def test_a_section_may_have_defaults_of_its_own():
    assert [leaf.default for leaf in params.leaves(Longer)] == [700, True]
    assert params.resolve(Longer, sets=["solver.restart=no"]) == Longer(Solver(700, restart=False))
    assert params.resolve(Longer, sets=["solver.iterations=5"]).solver.iterations == 5


@dataclass(frozen=True)
class Several:
    """The command takes several methods in place of the one of its section."""

    methods: tuple[str, ...] = option(("acs",), "Methods.", flag="--methods", aliases=("--method",))
    example: Example = params.section(Example, without=("method",))


def test_a_section_may_be_without_a_flag_that_its_command_has_another_for():
    about = {leaf.key: leaf.option for leaf in params.leaves(Several)}
    assert (about["example.method"].flag, about["example.method"].hidden) == (None, True)
    assert (about["example.weight"].flag, about["example.weight"].hidden) == ("--lambda", False)
    assert params.resolve(Several, sets=["example.method=ama"]).example.method == "ama"  # known to TOML and --set


SOURCES = ["file", "env", "set"]


def resolve_from(tmp_path, **given):
    """Resolve with solver.iterations given by some of the sources."""
    config = tmp_path / "config.toml"
    config.write_text(f"[solver]\niterations = {given['file']}\n" if "file" in given else "")
    env = {"IPCLI_SOLVER__ITERATIONS": given["env"]} if "env" in given else {}
    sets = [f"solver.iterations={given['set']}"] if "set" in given else []
    flags = {"solver.iterations": given["flag"]} if "flag" in given else {}
    return params.resolve(Example, config=config, env=env, sets=sets, flags=flags).solver.iterations


@pytest.mark.parametrize(
    "given",
    [c for n in range(4) for c in itertools.combinations(SOURCES, n)],
    ids=lambda given: "+".join(given) or "defaults",
)
@pytest.mark.parametrize("command_line", ["set", "flag"])
def test_precedence_in_every_combination_of_sources(tmp_path, given, command_line):
    values = {"file": 11, "env": "22", "set": "33"}
    chosen = {(command_line if source == "set" else source): values[source] for source in given}
    expected = next((int(values[source]) for source in reversed(SOURCES) if source in given), 300)
    assert resolve_from(tmp_path, **chosen) == expected


def test_a_key_given_twice_on_the_command_line_is_refused():
    with pytest.raises(ParameterError, match="--lambda and --set weight=... are both given"):
        params.resolve(Example, sets=["weight=1"], flags={"weight": "2"})
    with pytest.raises(ParameterError, match="weight=... is given twice"):
        params.resolve(Example, sets=["weight=1", "weight=1"])


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("wieght = 1", "weight"),
        ("[solver]\niteration = 5", "solver.iterations"),
        ("solver = 3", "solver.restart"),
        ("[weight]\nx = 1", "weight"),
    ],
)
def test_an_unknown_key_of_the_file_names_file_and_nearest(tmp_path, text, key):
    config = tmp_path / "my.toml"
    config.write_text(text)
    with pytest.raises(ParameterError, match=rf"my\.toml: unknown key '.*'; did you mean '{key}'"):
        params.resolve(Example, config=config)


def test_an_unknown_set_and_a_misspelt_variable_are_refused():
    with pytest.raises(ParameterError, match="--set: unknown key 'solver.iters'; did you mean 'solver.iterations'"):
        params.resolve(Example, sets=["solver.iters=5"])
    with pytest.raises(ParameterError, match="IPCLI_SOLVER__ITERATION'; did you mean 'IPCLI_SOLVER__ITERATIONS'"):
        params.resolve(Example, env={"IPCLI_SOLVER__ITERATION": "5"})


def test_variables_of_other_commands_and_programs_are_left_alone():
    env = {
        "IPCLI_THREADS": "2",
        "IPCLI_DATA": "x",
        "IPCLI_UNRELATED_TO_THIS": "1",
        "PATH": "y",
        "SOLVER__ITERATIONS": "7",
    }
    assert params.resolve(Example, env=env) == Example()


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("weight=-0.1", "float >= 0"),
        ("weight=nan", "float >= 0"),
        ("weight=inf", "float >= 0"),
        ("weight=", "float >= 0"),
        ("solver.iterations=0", "int from 1 to 10000"),
        ("solver.iterations=1.0", "int from 1 to 10000"),
        ("solver.restart=2", "true or false"),
        ("method=ADMM", "one of acs, ama"),
        ("alphas=1,x", "a list of float >= 0, with commas"),
        ("levels=1.5", "a list of int, with commas or none"),
        ("levels=" + "9" * 5000, "a list of int, with commas or none"),
        ("levels=9223372036854775808", "a list of int, with commas or none"),
        ("levels=²", "a list of int, with commas or none"),
        ("alphas=none", "a list of float >= 0, with commas"),
    ],
)
def test_a_bad_value_names_key_value_and_what_is_allowed(setting, expected):
    key, _, value = setting.partition("=")
    with pytest.raises(ParameterError) as caught:
        params.resolve(Example, sets=[setting])
    assert str(caught.value) == f"--set: {key} = '{value}': expected {expected}"


HUGE = f"weight = {10**400}"


@pytest.mark.parametrize(
    "text",
    [
        "weight = true",
        "weight = '1'",
        "solver.iterations = 2.0",
        "alphas = 1.0",
        "alphas = [[1.0]]",
        "method = 1",
        HUGE,
    ],
)
def test_toml_values_keep_their_types(tmp_path, text):
    config = tmp_path / "c.toml"
    config.write_text(text)
    if text == "weight = '1'":
        assert params.resolve(Example, config=config).weight == 1.0
    else:
        with pytest.raises(ParameterError, match=r"c\.toml: .* (expected|more than 64 bits)"):
            params.resolve(Example, config=config)


def test_an_unreadable_file_is_a_usage_error(tmp_path):
    (tmp_path / "bad.toml").write_text("a = = 1")
    for name, message in (("bad.toml", "not valid TOML"), ("none.toml", "No such file")):
        with pytest.raises(ParameterError, match=rf"{name}: .*{message}"):
            params.resolve(Example, config=tmp_path / name)


EXAMPLES = st.builds(
    Example,
    weight=st.floats(0, 1e30),
    method=st.sampled_from(["acs", "ama"]),
    reference=st.none() | st.text("abc05.", min_size=1),
    alphas=st.lists(st.floats(0, 1e30), min_size=1).map(tuple),
    levels=st.none() | st.lists(st.integers(-(1 << 63) + 1, (1 << 63) - 1), min_size=1).map(tuple),
    solver=st.builds(Solver, iterations=st.integers(1, 10_000), restart=st.booleans()),
)


def flat(example):
    """(key, value) of every leaf."""
    for leaf in params.leaves(type(example)):
        value = example
        for name in leaf.key.split("."):
            value = getattr(value, name)
        yield leaf.key, value


def as_text(value):
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


@given(EXAMPLES)
def test_every_value_survives_the_text_of_set_and_environment(example):
    texts = {key: as_text(value) for key, value in flat(example)}
    env = {"IPCLI_" + key.replace(".", "__").upper(): text for key, text in texts.items()}
    assert params.resolve(Example, sets=[f"{key}={text}" for key, text in texts.items()]) == example
    assert params.resolve(Example, env=env) == example


@given(EXAMPLES)
def test_every_value_survives_toml_and_the_dict_survives_json(tmp_path_factory, example):
    config = tmp_path_factory.mktemp("toml") / "c.toml"
    lines = [
        f"{key} = {json.dumps(list(v) if isinstance(v, tuple) else v)}" for key, v in flat(example) if v is not None
    ]
    config.write_text("\n".join(lines))
    assert params.resolve(Example, config=config) == example
    assert json.loads(json.dumps(params.as_dict(example))) == params.as_dict(example)


def test_leaves_come_in_order_of_declaration_with_sections_opened():
    keys = [leaf.key for leaf in params.leaves(Example)]
    assert keys == ["weight", "method", "reference", "alphas", "levels", "solver.iterations", "solver.restart"]
    assert list(params.as_dict(Example())) == ["weight", "method", "reference", "alphas", "levels", "solver"]
