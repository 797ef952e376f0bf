"""The table of commands, and the one place where an error becomes a line on stderr and an exit code.

0 done or up to date, 1 failed, 2 wrong usage, 3 no solution, 130 interrupted. A command's module is loaded when it is
called for.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import click

from ipcli import __version__
from ipcli.errors import IpcliError, nearest

INTERRUPTED = 130
TERMINATED = 143


class Command(NamedTuple):
    """What a command does in a line, words that it may be called with, and whether it is a console script too; `a-b`
    lives in ipcli/cli/a_b.py.
    """

    help: str
    example: str = ""
    is_script: bool = False


SECTIONS = {
    "Gaze localisation": {
        "gaze-sfm": Command(
            "Find where the wearer was and what they looked at.", "sample_data/room -o room.gaze.h5", is_script=True
        ),
        "import-recording": Command("Turn a head-mounted recording into one file.", "RECORDING -o walk.recording.h5"),
        "gaze-views": Command(
            "Make views for fuse-depth of a localised recording.", "sample_data/room room.gaze.h5 -o room.views.h5"
        ),
    },
    "Saliency": {
        "saliency": Command(
            "Tell what is likely to be looked at in a scene.", "room.gaze.h5 -o room.saliency.h5", is_script=True
        ),
        "saliency-train": Command("Learn from recorded fixations where people look.", "osie -o osie.model.h5"),
        "saliency-predict": Command(
            "Predict where people look in pictures, meshes and clouds.",
            "photo.jpg --model osie.model.h5 -o photo.maps.h5",
        ),
        "saliency-evaluate": Command(
            "Measure how well fixations are predicted, and by what.", "osie -o osie.evaluation.h5"
        ),
    },
    "Depth fusion": {
        "fuse-depth": Command(
            "Fuse depth maps of several views into one.",
            "sample_data/shapes --reference 005 -o shapes.fused.h5",
            is_script=True,
        ),
        "merge-depth": Command(
            "Join fused depth maps into one coloured cloud.", "a.fused.h5 b.fused.h5 c.fused.h5 -o scene.cloud.h5"
        ),
        "import-views": Command(
            "Turn a folder of depth maps and poses into one views file.", "sample_data/shapes -o shapes.views.h5"
        ),
        "kitti-views": Command(
            "Make views of KITTI stereo pairs.", "KITTI/training --poses poses.npz --scenes 11 -o views"
        ),
        "render-views": Command("Render depth maps of a mesh, with noise if wanted.", "mesh.ply -o mesh.views.h5"),
        "tune-fusion": Command(
            "Find the best weight of the data for each fusion method.", "a.views.h5 b.views.h5 -o tuning.h5"
        ),
        "evaluate-fusion": Command(
            "Measure the errors of all fusion methods on a scene.", "scene.views.h5 -o scene.trials.h5"
        ),
        "compare": Command("Compare methods by their errors over scenes.", "a.trials.h5 b.trials.h5 -o both.h5"),
    },
    "Action recognition": {
        "mocap-train": Command(
            "Learn the behaviours of actions from motions.",
            "sample_data/motions --actors ann,bob -o motions.model.h5",
            is_script=True,
        ),
        "mocap-classify": Command(
            "Name the action of a motion.", "motions.model.h5 take.bvh -o take.recognition.h5", is_script=True
        ),
        "mocap-evaluate": Command(
            "Tell how often actions are named right.", "sample_data/motions -o motions.evaluation.h5"
        ),
        "import-clips": Command(
            "Turn motion capture files into one file of labelled clips.", "sample_data/motions -o motions.clips.h5"
        ),
    },
    "Surfaces from one picture": {
        "brdf-train": Command(
            "Learn how materials look under all lights.",
            "sample_data/brdf/materials.toml -o materials.h5",
            is_script=True,
        ),
        "brdf-model": Command(
            "Model the surface of an object from one photograph.",
            "materials.h5 vase.png --mask vase.mask.png -o vase.h5",
            is_script=True,
        ),
    },
    "Animals": {
        "model-animal": Command(
            "Model an animal from images with part masks.",
            "sample_data/animal/standing.toml -o animal.glb",
            is_script=True,
        ),
    },
    "Any artefact": {
        "info": Command("Tell what a file holds and how it was made.", "shapes.fused.h5"),
        "report": Command("Draw an artefact as an HTML page.", "shapes.fused.h5 -o shapes.html"),
    },
}
COMMANDS = {name: command for section in SECTIONS.values() for name, command in section.items()}


def load(name: str) -> click.Command:
    """The click command of that name."""
    from ipcli.cli import options  # which the command loads as well, but the list of commands does not need

    told = COMMANDS[name]
    start = name if told.is_script else f"ipcli {name}"
    return options.command(name, f"{start} {told.example}" if told.example else "")()


class LazyGroup(click.Group):
    """A group that lists commands from the table and loads only the one that is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        return load(cmd_name) if cmd_name in COMMANDS else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS:
            raise click.UsageError(f"no command '{args[0]}'{nearest(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        widest = max(map(len, COMMANDS))
        for title, section in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(widest), command.help) for name, command in section.items()])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="ipcli")
def group() -> None:
    """Vision by regularisation and Bayesian inference. 'ipcli COMMAND --help' tells about a command."""


def main(arguments: list[str] | None = None) -> int:
    """`ipcli`: run a command, return its exit code."""
    return _guarded(group, "ipcli", arguments)


def command_main(name: str, arguments: list[str] | None = None) -> int:
    """A console script: the command of that name by itself."""
    return _guarded(load(name), name, arguments)


def __getattr__(name: str) -> Callable[..., int]:
    """The entry point of a console script: `fuse_depth` runs fuse-depth."""
    command = name.replace("_", "-")
    if command not in COMMANDS or not COMMANDS[command].is_script:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return partial(command_main, command)


def _guarded(command: click.Command, name: str, arguments: list[str] | None) -> int:
    """Every way in which a command may end, as an exit code."""
    _set_up_logging()
    _end_on_sigterm()
    try:
        code = command.main(arguments, name, standalone_mode=False)
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return error.exit_code
    except click.ClickException as error:
        return _failed(" ".join(error.format_message().split()), error.exit_code)
    except IpcliError as error:
        return _failed(str(error), error.exit_code)
    except BrokenPipeError:
        # the reader of our output went away; keep the interpreter from failing once more when it flushes at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Terminated:
        return _failed("terminated", TERMINATED)
    except (KeyboardInterrupt, click.Abort):
        return _failed("interrupted", INTERRUPTED)
    except OSError as error:
        return _failed(f"{error.filename}: {error.strerror}" if error.filename else str(error), 1)
    except MemoryError:
        return _failed(
            "out of memory. A smaller --max-memory, fewer or smaller views, or --executor serial, need less", 1
        )
    except Exception as error:
        return _failed(
            f"internal error: {type(error).__name__}: {error}. Run again with -vv and report what it prints", 1
        )


class Terminated(BaseException):
    """SIGTERM came: unwind as for an interrupt, so that temporary files and unpacked archives are removed."""


def _end_on_sigterm() -> None:
    """Raise Terminated on SIGTERM, unless whoever calls us (a notebook, nohup) has a handler or ignores it."""
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _raise_terminated)


def _raise_terminated(signum: int, frame: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # a second one must not cut the cleaning short
    raise Terminated


def _failed(message: str, code: int) -> int:
    """Say it in one line; with -vv the traceback first."""
    if logging.getLogger("ipcli").isEnabledFor(logging.DEBUG):
        import traceback

        traceback.print_exc()
    click.echo("Error: " + " ".join(message.splitlines()), err=True)
    return code


def _set_up_logging() -> None:
    logger = logging.getLogger("ipcli")
    logger.handlers = [logging.StreamHandler(sys.stderr)]
    logger.handlers[0].setFormatter(logging.Formatter("%(message)s"))
    logger.setLevel(logging.WARNING)
    logger.propagate = False
