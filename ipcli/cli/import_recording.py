"""`import-recording`: a head-mounted recording as one file."""

from __future__ import annotations

from pathlib import Path

import click

from ipcli.cli import options
from ipcli.params import Run
from ipcli.stages.gaze.parameters import ImportRecording


@click.command("import-recording")
@click.argument("recording", type=options.PATH)
@options.output("Recording artefact to write.")
@options.parameters(ImportRecording)
@options.common
def main(recording: Path, output: Path, params: ImportRecording, run: Run) -> None:
    """Turn RECORDING, the folder of a data set, into one file: pictures, calibration, gaze, truth."""
    from ipcli.stages.gaze import import_recording
    from ipcli.stages.kit import summary

    with options.progress("import-recording", run) as tell:
        import_recording.run(recording, output, params, run, tell)
    options.conclude(summary.of_recording(output), run, with_figures=True)
