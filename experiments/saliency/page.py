"""Pages, tables and bars of the saliency experiments: each is a module of this folder with `findings(arguments)`."""

from __future__ import annotations

from importlib import import_module

from experiments.kit.arguments import Arguments
from experiments.kit.run import Findings, run

EXPERIMENTS = {
    "tasks": "experiments.saliency.tasks",
    "osie": "experiments.saliency.fixations",
    "meshes": "experiments.saliency.fixations",
}


def make(arguments: Arguments) -> Findings:
    """The findings of one experiment."""
    return import_module(EXPERIMENTS[arguments.name]).findings(arguments)


if __name__ == "__main__":
    run(EXPERIMENTS, make)
