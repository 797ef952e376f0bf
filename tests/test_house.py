"""The rules of the house, checked on the source: who imports whom, what is heavy, how long things are, where what
belongs to one name lies, what help costs.

What breaks a rule today stands in a list that may only shrink: a name that is right by now must leave it.
"""

import ast
import graphlib
import os
import re
import statistics
import subprocess
import sys
import time
import tomllib
from collections import Counter

import click
import pytest

from ipcli import schema
from ipcli.cli import gaze_sfm
from ipcli.cli import main as cli
from tests.fixtures import house
from tests.fixtures.house import PACKAGE, ROOT, chapter, floor, modules

GROUND = {
    "__init__",
    "errors",
    "inputs",
    "schema",
    "params",
    "provenance",
    "rng",
    "executor",
    "threads",
    "progress",
    "memory",
}
MATHEMATICS = {"geometry", "kernels", "errors", "params", "rng", "threads", "progress"}
MAY_IMPORT = {
    "kernels": {"__init__"},  # the version, for the cache; a cached kernel must not depend on another file
    "geometry": {"geometry", "kernels", "errors", "threads"},
    "measurements": {"measurements", "geometry", "errors"},
    "inverse": {"inverse", *MATHEMATICS},
    "models": {"models", "inverse", "measurements", *MATHEMATICS},
    "io": {"io", "measurements", "geometry", *GROUND},
    "report": {"report", "io", "measurements", "geometry", *GROUND},
    "stages": {"stages", "models", "report", "io", "inverse", "measurements", "geometry", "kernels", *GROUND},
    "api": {"api", "stages", "models", "report", "io", "inverse", "measurements", "geometry", *GROUND},
    "cli": {"cli", "stages", *GROUND},
    "__main__": {"cli"},
    **{name: GROUND for name in GROUND},
}
HEAVY = {
    "numba",
    "scipy",
    "cv2",
    "h5py",
    "open3d",
    "pycolmap",
    "trimesh",
    "matplotlib",
    "skimage",
    "sklearn",
    "distributed",
}
PATHS = {"pathlib", "os", "tempfile", "shutil"}  # what a module that never sees a file does not need
VAGUE = {"utils", "util", "helpers", "helper", "manager", "base", "common", "misc"}
SECONDS = 0.1  # of the processor, for `import ipcli` and `ipcli --help`
CLICK_SECONDS = 0.07  # of `import click` where these hold
COMMAND_SECONDS = 0.2  # for the help of a command, which loads its parameters

# Names of classes that several modules share today.
SHARED_CLASSES: set[str] = set()
# Commands without a page of their own in docs/ today.
WITHOUT_PAGE = {
    "compare",
    "evaluate-fusion",
    "import-clips",
    "import-views",
    "info",
    "kitti-views",
    "merge-depth",
    "mocap-evaluate",
    "render-views",
    "report",
    "tune-fusion",
}
# Modules whose tests do not lie where the mirror would have them.
WITHOUT_MIRROR = {
    "ipcli.io.gaze.aria",
    "ipcli.io.gaze.artefact",
    "ipcli.io.gaze.boof",
    "ipcli.io.gaze.colmap_model",
    "ipcli.io.gaze.euroc",
    "ipcli.io.gaze.kitti",
    "ipcli.io.gaze.pictures",
    "ipcli.io.gaze.rgbd",
    "ipcli.io.gaze.trajectories",
    "ipcli.measurements.recording",
    "ipcli.models.gaze.adjustment",
    "ipcli.models.gaze.dense",
    "ipcli.models.gaze.evaluation",
    "ipcli.models.gaze.features",
    "ipcli.models.gaze.fixations",
    "ipcli.models.gaze.localise",
    "ipcli.models.gaze.retrieval",
    "ipcli.models.gaze.scene_map",
    "ipcli.models.gaze.surface",
    "ipcli.report.gaze.sides",
    "ipcli.stages.gaze.check",
    "ipcli.stages.gaze.exports",
    "ipcli.stages.gaze.gaze_views",
    "ipcli.stages.gaze.import_recording",
    "ipcli.stages.gaze.sources",
    "ipcli.report.fusion.accuracy",
    "ipcli.report.fusion.fused_depth",
    "ipcli.report.fusion.fusion_cloud",
    "ipcli.report.fusion.fusion_comparison",
    "ipcli.report.fusion.fusion_trials",
    "ipcli.report.fusion.fusion_tuning",
    "ipcli.report.fusion.views",
    "ipcli.report.mocap.action_evaluation",
    "ipcli.report.mocap.action_recognition",
    "ipcli.report.mocap.behaviours",
}


def assert_shrinks(found, allowed, rule):
    """What breaks the rule is what is known to break it, and nothing else."""
    assert not found - allowed, f"{rule}: {sorted(found - allowed)}"
    assert not allowed - found, f"right by now, take it from the list: {sorted(allowed - found)}"


def assert_none(broken):
    assert not broken, "\n" + "\n".join(broken)


def test_imports_go_downward_only():
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            for dotted in module.own
            if floor(dotted) not in MAY_IMPORT.get(module.floor, set())
        ]
    )


def test_no_import_is_circular():
    graph = house.dependencies(modules())
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        pytest.fail(" -> ".join(reversed(error.args[1])))


def test_commands_do_not_import_each_other():
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            if module.floor == "cli" and module.path.stem != "main"
            for dotted in module.own
            if floor(dotted) == "cli" and not f"{dotted}.".startswith("ipcli.cli.options.")
        ]
    )


def test_no_chapter_imports_another():
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            if module.chapter
            for dotted in module.own
            if chapter(dotted) not in (module.chapter, None)
        ]
    )


def test_a_command_belongs_to_one_chapter_or_to_none():
    assert_none(
        [
            f"{module.name} imports of {sorted(found)}"
            for module in modules()
            if module.floor == "cli" and len(found := {chapter(d) for d in module.own} - {None}) > 1
        ]
    )


def test_a_kit_knows_of_no_chapter():
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            if "kit" in module.path.parts
            for dotted in module.own
            if chapter(dotted)
        ]
    )


def test_what_is_neither_a_command_nor_a_chapter_knows_of_no_chapter():
    """Chapters are found by being there: by the registries of schema, of report and of the commands."""
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            if module.floor not in ("cli", "api", "__init__") and not module.chapter
            for dotted in module.own
            if chapter(dotted)
        ]
    )


def test_libraries_stay_where_they_belong():
    broken = []
    for module in modules():
        roots = {dotted.split(".")[0] for dotted in module.imports}
        allowed = {
            "click": module.floor == "cli",
            "numba": module.floor == "kernels",
            "h5py": module.path == PACKAGE / "io" / "files" / "h5.py",
        }
        broken += [f"{module.name} imports {name}" for name, right in allowed.items() if name in roots and not right]
        if module.floor in GROUND:
            foreign = roots - {"ipcli", "numpy", "distributed", *sys.stdlib_module_names}
            broken += [f"{module.name} imports {name}" for name in sorted(foreign)]
    assert_none(broken)


def test_the_mathematics_never_sees_a_path():
    assert_none(
        [
            f"{module.name} imports {dotted}"
            for module in modules()
            if module.floor in ("inverse", "models", "kernels") and module.path != PACKAGE / "kernels" / "__init__.py"
            for dotted in module.imports
            if dotted.split(".")[0] in PATHS
        ]
    )


def test_heavy_libraries_are_imported_where_they_are_used():
    assert_none(
        [
            f"{module.name} imports {dotted} at its top"
            for module in modules()
            for dotted in house.imported(module.tree.body)
            if (root := dotted.split(".")[0]) in HEAVY and not (root == "numba" and module.floor == "kernels")
        ]
    )


def test_a_class_name_stands_for_one_thing():
    count = Counter(name for module in modules() for name in module.classes)
    assert_shrinks({name for name, n in count.items() if n > 1}, SHARED_CLASSES, "classes that share a name")


def test_modules_and_functions_are_short():
    broken = [f"{module.name}: {len(module.lines)} lines" for module in modules() if len(module.lines) > 400]
    for module in modules():
        sizes = {function.name: module.code_lines(function) for function in module.functions}
        broken += [f"{module.name}.{name}: {size} lines of code" for name, size in sizes.items() if size > 60]
    assert_none(broken)


def test_most_functions_are_very_short():
    sizes = [module.code_lines(function) for module in modules() for function in module.functions]
    assert statistics.median(sizes) <= 10
    assert statistics.quantiles(sizes, n=10)[-1] <= 30


def test_every_module_and_public_function_says_what_it_is_for():
    broken = []
    for module in modules():
        if module.tree.body and not ast.get_docstring(module.tree):
            broken.append(module.name)
        if module.floor != "cli":  # a command's docstring is its help
            broken += [
                f"{module.name}.{node.name}"
                for node in module.tree.body
                if isinstance(node, (ast.FunctionDef, ast.ClassDef))
                and not node.name.startswith("_")
                and not ast.get_docstring(node)
            ]
    assert_none(broken)


def test_names_say_what_a_module_holds():
    assert_none([module.name for module in modules() if VAGUE & set(module.name.split("."))])


# One stem: a command, its module, its stage, its page, its configurations and its tests.


def stem(name):
    return name.replace("-", "_")


def stage(name):
    """The modules of this name among the stages: one, in the folder of a chapter or of the kit."""
    return sorted((PACKAGE / "stages").glob(f"*/{stem(name)}.py"))


def test_each_section_of_the_table_is_a_chapter():
    """Or the kit; a chapter stands in one section."""
    folders = {
        title: {path.parent.name for name in section for path in stage(name)} for title, section in cli.SECTIONS.items()
    }
    assert all(len(found) == 1 for found in folders.values()), folders
    assert len({*map(frozenset, folders.values())}) == len(folders), folders
    assert list(cli.COMMANDS) == [name for section in cli.SECTIONS.values() for name in section]


def test_every_command_has_a_module_a_stage_and_a_page_of_its_name():
    assert {path.stem for path in (PACKAGE / "cli").glob("*.py")} - {"__init__", "main", "options"} == {
        stem(name) for name in cli.COMMANDS
    }
    assert_none(
        [f"stages/<chapter>/{stem(name)}.py: {len(stage(name))}" for name in cli.COMMANDS if len(stage(name)) != 1]
    )
    missing = {name for name in cli.COMMANDS if not (ROOT / "docs" / f"{name}.md").is_file()}
    assert_shrinks(missing, WITHOUT_PAGE, "commands without a page in docs/")


def test_options_that_messages_name_exist():
    """`Give --gaze-size` is no help where no command has it."""
    commands = [*map(cli.load, cli.COMMANDS), gaze_sfm.check]
    options = [option for command in commands for option in command.params]
    known = {name for option in options for name in (*option.opts, *option.secondary_opts)}
    broken = []
    for module in (module for module in modules() if module.floor in ("models", "stages", "io")):
        for node in module.nodes:
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", node.value)) - {"--help", *known}
                broken += [f"{module.name}:{node.lineno} {name}" for name in sorted(named)]
    assert_none(broken)


def test_configurations_are_in_folders_named_after_commands():
    folders = [path.name for path in (PACKAGE / "configs").iterdir() if path.is_dir()]
    assert set(folders) <= set(cli.COMMANDS)


def test_tests_mirror_the_package():
    """The tests of ipcli/a/b.py are in tests/a/test_b.py or, of many parts, in tests/a/test_b_*.py. Those of the
    command line are by what a user does, those of the schema by kind.
    """
    missing = set()
    for module in modules():
        place = ROOT / "tests" / module.path.relative_to(PACKAGE).parent
        if module.floor in ("cli", "schema") or module.path.stem in ("__init__", "__main__", "parameters"):
            continue
        if not ((place / f"test_{module.path.stem}.py").is_file() or any(place.glob(f"test_{module.path.stem}_*.py"))):
            missing.add(module.name)
    assert_shrinks(missing, WITHOUT_MIRROR, "modules without tests of their own")


# Tests.


def test_tests_import_fixtures_and_never_other_tests():
    broken = []
    for module in modules("tests"):
        for dotted in module.imports:
            if dotted.split(".")[0] == "tests" and not f"{dotted}.".startswith("tests.fixtures."):
                broken.append(f"{module.name} imports {dotted}")
    assert_none(broken)


def test_what_is_no_test_is_a_fixture():
    fixtures = ROOT / "tests" / "fixtures"
    assert_none(
        [
            module.name
            for module in modules("tests")
            if fixtures not in module.path.parents
            and not module.path.name.startswith("test_")
            and module.path.name != "conftest.py"
        ]
    )


# The command line.


def run(*arguments):
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, *arguments], env=env, capture_output=True, text=True, cwd=ROOT)


def test_loading_every_command_loads_neither_numpy_nor_anything_heavy():
    code = f"""
import sys
from ipcli.cli import main
for name in main.COMMANDS:
    main.load(name)
    print(name, sorted({{*{sorted(HEAVY)}, 'numpy'}} & sys.modules.keys()))
"""
    done = run("-c", code)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "".join(f"{name} []\n" for name in cli.COMMANDS)


def assert_quick(bound, *arguments):
    """The best of several, so that a busy machine does not count; on a slower one than the bound is for, measured by
    an import of click alone, the bound is as much larger.
    """
    best, alone = float("inf"), float("inf")
    for _ in range(12):
        alone = min(alone, processor_seconds("-c", "import click"))
        best = min(best, processor_seconds(*arguments))
        if best < bound:
            break
    assert best < bound * max(1, alone / CLICK_SECONDS)


def processor_seconds(*arguments):
    started = _children_seconds()
    done = run(*arguments)
    assert done.returncode == 0, done.stderr
    return _children_seconds() - started


def _children_seconds():
    """Of all child processes that have ended; on Windows, which does not tell, the time of day."""
    times = os.times()
    return times.children_user + times.children_system if os.name != "nt" else time.perf_counter()


@pytest.mark.parametrize("arguments", [("-c", "import ipcli"), ("-m", "ipcli", "--help")], ids=" ".join)
def test_the_package_and_its_help_are_quick(arguments):
    assert_quick(SECONDS, *arguments)


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_help_is_quick(name):
    assert_quick(COMMAND_SECONDS, "-m", "ipcli", name, "--help")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_no_two_options_of_a_command_share_a_name_and_all_have_help(name):
    command = cli.load(name)
    names = [option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)]
    assert len(set(names)) == len(names)
    assert command.help
    assert all(parameter.help for parameter in command.params if isinstance(parameter, click.Option))


def test_the_console_scripts_are_those_of_the_table():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    table = {name: stem(name) for name, command in cli.COMMANDS.items() if command.is_script}
    assert scripts == {"ipcli": "ipcli.cli.main:main"} | {
        name: f"ipcli.cli.main:{entry}" for name, entry in table.items()
    }
    for name, entry in table.items():
        assert getattr(cli, entry).args == (name,)


def test_the_readme_names_every_command_and_every_exit_code():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `?([\w-]+)`?(?: \*)? \|", text, flags=re.MULTILINE)
    assert {*cli.COMMANDS, "0", "1", "2", "3", "130"} <= set(rows)


def test_the_page_of_the_formats_is_up_to_date():
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    assert page == schema.markdown(), "run python tools/make_formats.py"
