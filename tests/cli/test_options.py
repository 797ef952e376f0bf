"""Progress on a terminal and in a log, and results as text and JSON."""

import io
import json
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
import pytest

from ipcli.cli import options
from ipcli.params import Run, option, section


class Terminal(io.StringIO):
    def isatty(self):
        return True


def screen(text):
    """What is left to see of one line with carriage returns."""
    line = ""
    for part in text.split("\r"):
        line = part + line[len(part) :]
    return line.rstrip()


def test_a_first_word_may_name_another_command(capsys):
    @click.command("other")
    @click.argument("what")
    def other(what):
        click.echo(f"other of {what}")

    @click.command("one", cls=options.first_word(also=lambda: other))
    @click.argument("what")
    def one(what):
        click.echo(f"one of {what}")

    for line, told in ((["also", "x"], "other of x"), (["x"], "one of x")):
        one.main(line, "one", standalone_mode=False)
        assert capsys.readouterr().out.strip() == told
    with pytest.raises(click.UsageError, match="Missing"):
        one.main(["also"], "one", standalone_mode=False)


def test_the_command_of_a_name_is_loaded_when_it_is_asked_for():
    assert options.command("merge-depth")().name == "merge-depth"
    assert "--set" in options.command("saliency-train")().epilog  # as where it is called by its own name


def test_facts_are_lines_below_the_name_of_the_output_or_one_object(capsys):
    facts = {"output": "x.h5", "points": 3, "overlap": {"front": 0.91, "side": 0.88}}
    options.conclude(facts, Run(), with_figures=True)
    assert capsys.readouterr().out == "x.h5\npoints: 3\noverlap: front 0.91, side 0.88\n"
    options.conclude(facts, Run(json=True), with_figures=True)
    assert json.loads(capsys.readouterr().out) == facts


def test_a_terminal_shows_one_bar_that_leaves_no_trace():
    stream = Terminal()
    tell = options.Teller("fuse", stream)
    tell(0.25, "a long name")
    assert screen(stream.getvalue()) == "fuse [##########..............................]  25% a long name"
    tell(1.0, "b")
    assert screen(stream.getvalue()) == "fuse [########################################] 100% b"
    tell.close()
    assert screen(stream.getvalue()) == ""
    assert "\n" not in stream.getvalue()


def test_a_log_gets_a_line_every_30_seconds():
    stream, now = io.StringIO(), [0.0]
    tell = options.Teller("fuse", stream, clock=lambda: now[0])
    for second in range(100):
        now[0] = float(second)
        tell(second / 100, f"view {second}")
    tell.close()
    assert stream.getvalue() == "fuse: 30% view 30\nfuse: 60% view 60\nfuse: 90% view 90\n"


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()])
def test_quiet_says_nothing(stream):
    tell = options.Teller("fuse", stream, quiet=True, clock=iter(range(0, 1000, 100)).__next__)
    tell(0.5, "a")
    tell.close()
    assert stream.getvalue() == ""


def test_progress_goes_to_stderr_and_is_cleared_after_an_error(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr", Terminal())
    import sys

    def fail_half_way():
        with options.progress("fuse", Run()) as tell:
            tell(0.5, "a")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_half_way()
    assert "50%" in sys.stderr.getvalue()
    assert screen(sys.stderr.getvalue()) == ""
    assert capsys.readouterr().out == ""


def test_json_is_strict_whatever_numbers_come(capsys):
    result = {
        "output": Path("a/b.h5"),
        "rmse": np.float32(0.5),
        "none": float("nan"),
        "k": np.arange(2),
        "views": [{"share": np.inf}],
    }
    options.conclude(result, Run(json=True))
    expected = {"output": "a/b.h5", "rmse": 0.5, "none": None, "k": [0, 1], "views": [{"share": None}]}
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == expected


def test_text_is_the_output_or_each_fact(capsys):
    options.conclude({"output": Path("a.h5"), "rmse": 1.0}, Run())
    options.conclude({"rmse": 1.0, "views": 3}, Run())
    assert capsys.readouterr().out == "a.h5\nrmse: 1\nviews: 3\n"


def test_numbers_have_four_digits_on_the_console_and_all_in_json(capsys):
    facts = {
        "output": "x",
        "volume": np.float64(123456.789),
        "by_side": {"left": 1 / 3},
        "closed": True,
        "faces": 123456,
    }
    options.conclude(facts, Run(), with_figures=True)
    assert capsys.readouterr().out == "x\nvolume: 123457\nby side: left 0.3333\nclosed: yes\nfaces: 123456\n"
    options.conclude(facts, Run(json=True))
    assert json.loads(capsys.readouterr().out)["by_side"]["left"] == 1 / 3


def test_a_dry_run_names_no_result(capsys):
    for result in (Path("x.h5"), {"output": "x.h5", "points": 3}):
        options.conclude(result, Run(dry_run=True), with_figures=True)
        assert capsys.readouterr().out == ""
        options.conclude(result, Run(dry_run=True, json=True))
        assert json.loads(capsys.readouterr().out) == {"output": "x.h5", "dry_run": True}


def test_a_figure_is_text_on_the_console_and_a_number_in_json(capsys):
    from ipcli.stages.kit.summary import Figure

    facts = {"output": "x.h5", "observed": Figure(0.25, "25 % of the pixels")}
    options.conclude(facts, Run(), with_figures=True)
    assert capsys.readouterr().out == "x.h5\nobserved: 25 % of the pixels\n"
    options.conclude(facts, Run(json=True), with_figures=True)
    assert json.loads(capsys.readouterr().out) == {"output": "x.h5", "observed": 0.25}


@dataclass(frozen=True)
class OneOfThem:
    method: str = option("a", "One method.", flag="--method")


@dataclass(frozen=True)
class SomeOfThem:
    methods: tuple[str, ...] = option(("a",), "Some methods.", flag="--methods", aliases=("--method",))
    section: OneOfThem = section(OneOfThem, without=("method",))


@pytest.mark.parametrize("flag", ["--methods", "--method"])
def test_a_flag_may_be_spelt_in_two_ways_and_stand_for_one_of_a_section(flag):
    @click.command()
    @options.parameters(SomeOfThem)
    def command(params):
        return params

    assert command.main([flag, "b,c"], standalone_mode=False) == SomeOfThem(("b", "c"))
    assert "One method" not in f"{command.get_help(click.Context(command))}{command.callback.epilog}"
