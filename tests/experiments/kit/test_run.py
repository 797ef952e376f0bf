"""An experiment from its argument line to its files, and a new chapter's from ten lines of make."""

import json
import subprocess
import sys

import numpy as np
import pytest

from experiments.kit import figures
from experiments.kit.arguments import Arguments, parse_arguments
from experiments.kit.charts import Chart, Panel
from experiments.kit.run import Findings, page_of, quick_lead, run
from ipcli.report.kit.curves import Series
from ipcli.report.kit.page import section
from ipcli.report.kit.pictures import robust
from tests.fixtures.makefile import ROOT, make
from tests.fixtures.pages import sound

CHAPTER = """# Toys: make experiments/toy-box
BOX := $(call experiment,toy,box)
TOYS := $(if $(QUICK),1,1 2 3)

$(BOX)/%.h5:
	mkdir -p $(@D) && echo $* > $@
$(BOX)/index.html: $(TOYS:%=$(BOX)/%.h5)
"""
PAGE = '''"""The page of the toys."""

from experiments.kit.run import Findings, page_of, quick_lead, run


def make(arguments):
    rows = [{"toy": path.stem} for path in arguments.files]
    return Findings(page_of("toy", "Toys", quick_lead("one toy") if arguments.quick else "All"), rows)


if __name__ == "__main__":
    run(["box"], make)
'''


def test_the_argument_line_is_a_name_a_page_and_files(tmp_path):
    line = ["--quick", "box", str(tmp_path / "index.html"), "a.h5", "b.h5"]
    parsed = parse_arguments(["box"], line)
    assert (parsed.name, parsed.quick, [file.name for file in parsed.files]) == ("box", True, ["a.h5", "b.h5"])
    assert not parse_arguments(["box"], line[1:]).quick


@pytest.mark.parametrize("line", [[], ["box"], ["box", "x.html"], ["sand", "x.html", "a.h5"]])
def test_a_wrong_argument_line_ends_with_usage(line, capsys):
    with pytest.raises(SystemExit) as ended:
        parse_arguments(["box"], line)
    assert ended.value.code == 2
    assert "usage" in capsys.readouterr().err


def test_a_run_leaves_the_page_the_table_and_the_figures(tmp_path):
    series = Series("a", np.arange(3.0), np.arange(3.0))
    panel = Panel("p", np.eye(8), robust([np.eye(8)], "turbo"))

    def draw(folder):
        figures.charts(folder, "chart", [Chart("T", "x", "y", (series,))])
        figures.pictures(folder, "panel", [[panel]])

    def findings(arguments: Arguments) -> Findings:
        part = section("S", Chart("T", "x", "y", (series,)).svg(), panel.figure())
        return Findings(
            page_of("toy", "Title", quick_lead("toys"), None, part), [{"n": 1}], {"of": arguments.name}, draw
        )

    out = tmp_path / "new" / "index.html"
    run(["box"], findings, ["box", str(out), "a.h5"])
    sound(out.read_text())
    assert "quick look at toys" in out.read_text()
    assert "experiments/toy" in out.read_text()
    assert json.loads(out.with_suffix(".json").read_text()) == {"of": "box", "rows": [{"n": 1}]}
    assert sorted(path.name for path in (out.parent / "figures").iterdir()) == [
        f"{name}.{suffix}" for name in ("chart", "panel") for suffix in ("pdf", "png")
    ]


def test_a_new_chapter_is_a_folder_with_a_page_and_ten_lines_of_make(tmp_path):
    toy = tmp_path / "experiments" / "toy"
    toy.mkdir(parents=True)
    (tmp_path / "experiments" / "kit").symlink_to(ROOT / "experiments" / "kit")
    (toy / "toy.mk").write_text(CHAPTER)
    (toy / "page.py").write_text(PAGE)
    told = make(tmp_path, "experiments/toy-box")
    made = tmp_path / "build" / "experiments" / "toy-box" / "index.html"
    assert f"Open {made} in a browser" in told
    assert [row["toy"] for row in json.loads(made.with_suffix(".json").read_text())["rows"]] == ["1", "2", "3"]
    make(tmp_path, "QUICK=1", "experiments/toy-box")
    quick = tmp_path / "build" / "experiments" / "toy-box-quick"
    assert "quick look at one toy" in (quick / "index.html").read_text()
    assert [path.name for path in quick.glob("*.h5")] == ["1.h5"]
    assert "python" not in make(tmp_path, "experiments/toy-box"), "nothing is done twice"


@pytest.mark.parametrize("quick", [(), ("QUICK=1",)], ids=["whole", "quick"])
def test_every_experiment_that_a_makefile_names_can_be_planned(tmp_path, quick):
    """make knows a rule for every step, and gives each page its files."""
    named = [
        word
        for path in sorted(ROOT.glob("experiments/*/*.mk"))
        for line in path.read_text().splitlines()
        if line.startswith("#   make experiments/")
        for word in [line.split()[2]]
    ]
    assert len(named) >= 9
    sources = ["fusion/meshes_objects/meshes_objects.tar.xz", "fusion/meshes_urban/meshes_urban.tar.xz"]
    sources += ["fusion/kitti2012_multiview", "fusion/kitti2012_pairs", "fusion/livingroom1_clean_micro"]
    sources += [
        "mocap/hdm05_smij11/hdm05_smij11_raw_asf_amc.tar.xz",
        "mocap/florence3d",
        "mocap/utkinect/utkinect.tar.xz",
    ]
    for source in sources:
        (tmp_path / "nothing" / source).mkdir(parents=True)
    for name in named:
        plan = make(tmp_path, "-n", *quick, name)
        assert f"/{name.split('/')[1]}" in plan
        assert name.endswith("kitchen") or f".page {'--quick ' if quick else ''}" in plan


def test_benchmarks_of_all_chapters_are_run_and_quick_if_asked(tmp_path):
    for quick in ((), ("QUICK=1",)):
        plan = make(tmp_path, "-n", *quick, "benchmarks", "RECORDING=walk")
        run = [line for line in plan.splitlines() if "-m benchmarks." in line]
        assert [line.split("-m benchmarks.")[1].split()[0] for line in run] == [
            *("fusion.solver", "fusion.baselines", "fusion.scaling", "fusion.memory", "fusion.tiles"),
            *("mocap.gibbs", "mocap.speed", "mocap.peers"),
            *("gaze.paths", "saliency.speed"),
            *("brdf.speed", "brdf.solvers"),
        ]
        assert all(("--quick" in line) == bool(quick) for line in run)
        assert all("--recording walk" in line for line in run[-4:-2])
    alone = make(tmp_path, "-n", "benchmarks/gaze-paths", "benchmarks/saliency-speed")
    assert alone.count("--quick") == 2  # without a recording, a generated one


def test_every_experiment_tells_its_usage():
    for chapter in ("fusion", "mocap"):
        command = [sys.executable, "-m", f"experiments.{chapter}.page", "--help"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert "--quick" in done.stdout
