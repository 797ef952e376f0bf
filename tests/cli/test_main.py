"""How a command ends: exit code, one line of error, and nothing on stdout but results."""

import json
import os
import signal
import subprocess
import sys
import types
from dataclasses import dataclass, field
from pathlib import Path

import click
import pytest

from ipcli import __version__
from ipcli.cli import main as cli
from ipcli.cli import options
from ipcli.errors import IpcliError, NoSolution, ParameterError
from ipcli.params import Run, option


@dataclass(frozen=True)
class Solver:
    iterations: int = option(300, "Most iterations.", low=1)


@dataclass(frozen=True)
class Params:
    weight: float = option(1.0, "Weight of the data.", flag="--lambda", low=0.0, unit="1/m")
    method: str = option("acs", "Algorithm.", flag="--method", choices=("acs", "ama"))
    robust: bool = option(True, "Robust loss.", flag="--robust")
    alphas: tuple[float, ...] = option((1.0, 2.0), "Weights of the orders.", flag="--alphas")
    scale: float | None = option(None, "Scale.")
    solver: Solver = field(default_factory=Solver)


ERRORS = {
    "none": None,
    "failed": IpcliError("the file x: broken"),
    "usage": ParameterError("bad value"),
    "nothing": NoSolution("no overlap between views"),
    "interrupt": KeyboardInterrupt(),
    "disk": OSError(28, "No space left on device", "/out/f.h5"),
    "memory": MemoryError(),
    "bug": ZeroDivisionError("division\nby zero"),
}


@pytest.fixture(autouse=True)
def probe(monkeypatch):
    """A command that prints the parameters it got, or fails as it is told."""

    @click.command("probe")
    @click.argument("error", default="none")
    @options.parameters(Params)
    @options.common
    def main(error: str, params: Params, run: Run) -> None:
        """Probe."""
        if ERRORS[error]:
            raise ERRORS[error]
        seen.append((params, run))
        options.conclude(Path("result.h5"), run)

    seen: list[tuple[Params, Run]] = []
    monkeypatch.setitem(sys.modules, "ipcli.cli.probe", types.SimpleNamespace(main=main))
    monkeypatch.setitem(cli.COMMANDS, "probe", cli.Command("Probe."))
    monkeypatch.setitem(cli.SECTIONS, "Probes", {"probe": cli.Command("Probe.")})
    monkeypatch.setattr(os, "environ", os.environ.copy())
    return seen


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        ("failed", 1, "the file x: broken"),
        ("usage", 2, "bad value"),
        ("nothing", 3, "no overlap between views"),
        ("interrupt", 130, "interrupted"),
        ("disk", 1, "/out/f.h5: No space left on device"),
        ("memory", 1, "out of memory. "),
        ("bug", 1, "internal error: ZeroDivisionError: division by zero. Run again with -vv"),
    ],
)
def test_each_error_is_one_line_and_its_exit_code(error, code, line, capsys):
    assert cli.main(["probe", error]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.lstrip("\n").startswith(f"Error: {line}")  # click moves on from the line of ^C
    assert err.strip().count("\n") == 0
    assert cli.command_main("probe", [error, "-v"]) == code
    assert capsys.readouterr() == (out, err)


@pytest.mark.parametrize("arguments", [["failed"], ["bug"], ["--lambda", "x"], ["--threads", "x"]], ids=" ".join)
def test_the_traceback_comes_only_with_vv_and_before_the_line(arguments, capsys):
    assert cli.main(["probe", *arguments, "-vv"]) in (1, 2)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("Traceback")
    assert lines[-1].startswith("Error: ")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["prob"], "no command 'prob'; did you mean 'probe'?"),
        (["probe", "--lamda", "1"], "No such option"),
        (["probe", "--lambda", "-1"], "--lambda: weight = '-1': expected float >= 0"),
        (["probe", "--method", "admm"], "--method: method = 'admm': expected one of acs, ama"),
        (
            ["probe", "--set", "solver.iteration=1"],
            "--set: unknown key 'solver.iteration'; did you mean 'solver.iterations'?",
        ),
        (["probe", "--seed", "-1"], "Invalid value for '--seed'"),
        (["probe", "--config", "absent.toml"], "absent.toml: cannot be read: No such file"),
    ],
)
def test_wrong_usage_is_one_line_and_code_2(arguments, line, capsys):
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"Error: {line}")
    assert err.count("\n") == 1


def test_flag_over_environment_over_file_over_default(probe, tmp_path, monkeypatch):
    config = tmp_path / "c.toml"
    config.write_text("weight = 2\nscale = 2\n[solver]\niterations = 2\n")
    monkeypatch.setenv("IPCLI_WEIGHT", "3")
    monkeypatch.setenv("IPCLI_SOLVER__ITERATIONS", "3")
    assert cli.main(["probe", "--config", str(config), "--lambda", "4"]) == 0
    assert probe[0][0] == Params(weight=4.0, scale=2.0, solver=Solver(iterations=3))


def test_flags_of_every_type_reach_the_stage(probe):
    arguments = "--lambda 0.5 --method ama --no-robust --alphas 1,2,3 --set scale=none --set solver.iterations=7"
    run = "-q -n --overwrite --json --seed 9 --executor processes:2"
    assert cli.main(["probe", *arguments.split(), *run.split()]) == 0
    assert probe == [
        (
            Params(0.5, "ama", False, (1.0, 2.0, 3.0), None, Solver(7)),
            Run(seed=9, overwrite=True, dry_run=True, json=True, verbosity=-1, executor="processes:2"),
        )
    ]


def test_without_flags_everything_is_as_declared(probe):
    assert cli.main(["probe"]) == 0
    assert probe == [(Params(), Run())]


def test_threads_reach_every_library_by_flag_or_environment(probe, monkeypatch):
    names = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    assert cli.main(["probe", "--threads", "3"]) == 0
    assert [os.environ[name] for name in names] == ["3"] * 3
    monkeypatch.setenv("IPCLI_THREADS", "2")
    assert cli.main(["probe"]) == 0
    assert [os.environ[name] for name in names] == ["2"] * 3
    assert [run.threads for _, run in probe] == [3, 2]


def test_help_shows_units_defaults_choices_ranges_and_the_rare_settings(capsys):
    assert cli.main(["probe", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for part in (
        "--lambda FLOAT Weight of the data. [in 1/m; float >= 0; default: 1.0]",
        "--method [acs|ama] Algorithm. [default: acs]",
        "--robust / --no-robust Robust loss. [default: true]",
        "--alphas FLOAT,... Weights of the orders. [default: 1.0,2.0]",
        "Settings for --set / TOML:",
        "scale (float or none): Scale. [default: none]",
        "solver.iterations (int >= 1): Most iterations. [default: 300]",
    ):
        assert part in text
    assert text.index("Settings for") > text.index("--lambda")


def test_stdout_holds_the_path_or_one_json_object(capsys):
    assert cli.main(["probe"]) == 0
    assert capsys.readouterr().out == "result.h5\n"
    assert cli.main(["probe", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"output": "result.h5"}


def test_help_and_version(capsys):
    assert cli.main(["--version"]) == 0
    assert __version__ in capsys.readouterr().out
    assert cli.main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(name in text and command.help in " ".join(text.split()) for name, command in cli.COMMANDS.items())
    assert cli.main([]) == 2


def run_python(code, **more):
    env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        [sys.executable, "-c", code], env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more
    )


ENDLESS = """
import signal, sys, types, time, click
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the shell that started the tests ignores it
from ipcli.cli import main
@click.command("endless")
def endless():
    while True:
        print("x" * 1000, flush=True)
        time.sleep(0.01)
sys.modules["ipcli.cli.endless"] = types.SimpleNamespace(main=endless)
main.COMMANDS["endless"] = main.Command("")
sys.exit(main.main(["endless"]))
"""


@pytest.fixture(params=["as usual", "ignored"])
def interrupts(request):
    """What a child finds when it starts: a shell that runs the tests in the background ignores interrupts."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN if request.param == "ignored" else signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interrupts")
def test_ctrl_c_ends_with_130():
    with run_python(ENDLESS) as process:
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert process.communicate()[1] == b"\nError: interrupted\n"
    assert process.returncode == 130


def test_sigterm_unwinds_and_ends_with_143():
    code = ENDLESS.replace("    while True:", "  try:\n    while True:").replace(
        'sys.modules["ipcli.cli.endless"]',
        '  finally:\n    print("removed", file=sys.stderr)\nsys.modules["ipcli.cli.endless"]',
    )
    with run_python(code) as process:
        process.stdout.readline()
        process.terminate()
        assert process.communicate()[1] == b"removed\nError: terminated\n"
    assert process.returncode == 143


def test_a_reader_that_goes_away_ends_the_command_without_a_word():
    with run_python(ENDLESS) as process:
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_the_example_of_each_help_can_be_called_as_it_stands(name, capsys):
    example = cli.COMMANDS[name].example
    assert example
    assert cli.load(name).make_context(name, example.split()).params
    assert cli.command_main(name, ["-h"]) == 0
    assert f" {example}\n" in capsys.readouterr().out


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_the_help_of_each_option_begins_with_a_capital_or_a_choice(name):
    first = {parameter.help.split()[0] for parameter in cli.load(name).params if getattr(parameter, "help", None)}
    assert [word for word in first if word[0].islower() and not word.endswith(":")] == []
