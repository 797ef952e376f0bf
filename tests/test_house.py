"""The rules of the house, checked on the source: who imports whom, what is heavy, how long things are, what
help costs.
"""

import ast
import os
import re
import statistics
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import click
import pytest

from ipcli import schema
from ipcli.cli import main as cli

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "ipcli"
MODULES = sorted(PACKAGE.rglob("*.py"))
GROUND = {"__init__", "errors", "schema", "params", "provenance", "rng", "executor", "threads", "progress"}
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
    "cli": {"cli", "stages", *GROUND},
    "__main__": {"cli"},
    **{name: GROUND for name in GROUND},
}
CHAPTERS = {"fusion", "mocap", "gaze", "saliency", "animal", "brdf"}
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
HELP_SECONDS = 0.3


def name_of(path):
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


def imports(nodes):
    """Dotted names that import statements among `nodes` load; `from a import b` counts as a.b."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def floor(dotted):
    """`ipcli.io.files.h5` -> io; `ipcli.__version__` -> __init__."""
    parts = dotted.split(".")
    inside = len(parts) > 1 and ((PACKAGE / parts[1]).is_dir() or (PACKAGE / f"{parts[1]}.py").is_file())
    return parts[1] if inside else "__init__"


def each_module(function):
    return pytest.mark.parametrize("path", MODULES, ids=name_of)(function)


@each_module
def test_imports_go_downward_only(path):
    here = floor(name_of(path))
    for dotted in imports(ast.walk(tree(path))):
        if dotted.split(".")[0] == "ipcli":
            assert floor(dotted) in MAY_IMPORT[here], f"{here} imports {dotted}"


@each_module
def test_commands_do_not_import_each_other(path):
    here = floor(name_of(path))
    own = [dotted for dotted in imports(ast.walk(tree(path))) if dotted.startswith("ipcli.")]
    if here == "cli" and path.stem != "main":
        assert all(d.startswith("ipcli.cli.options") or d == "ipcli.cli.options" for d in own if floor(d) == "cli")


def chapter(dotted):
    """`ipcli.models.fusion.fuse` -> fusion; None outside the folders of chapters."""
    parts = dotted.split(".")
    return parts[2] if len(parts) > 2 and parts[2] in CHAPTERS and parts[1] != "io" else None


@each_module
def test_no_chapter_imports_another(path):
    here = chapter(name_of(path))
    if here:
        others = {chapter(dotted) for dotted in imports(ast.walk(tree(path))) if dotted.startswith("ipcli.")}
        assert others <= {here, None}


@each_module
def test_a_kit_knows_of_no_chapter(path):
    if "kit" in path.parts:
        found = [dotted for dotted in imports(ast.walk(tree(path))) if dotted.startswith("ipcli.")]
        assert [dotted for dotted in found if chapter(dotted)] == []


@each_module
def test_libraries_stay_where_they_belong(path):
    here, roots = floor(name_of(path)), {dotted.split(".")[0] for dotted in imports(ast.walk(tree(path)))}
    assert "click" not in roots or here == "cli"
    assert "numba" not in roots or here == "kernels"
    assert "h5py" not in roots or path == PACKAGE / "io" / "files" / "h5.py"
    if here in GROUND:
        assert roots <= {"ipcli", "numpy", "distributed", *sys.stdlib_module_names}


@each_module
def test_heavy_libraries_are_imported_where_they_are_used(path):
    at_top = {dotted.split(".")[0] for dotted in imports(tree(path).body)}
    assert at_top & HEAVY <= ({"numba"} if floor(name_of(path)) == "kernels" else set())


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


@pytest.mark.parametrize(
    "arguments", [[], *([name] for name in cli.COMMANDS)], ids=lambda arguments: " ".join(["ipcli", *arguments])
)
def test_help_is_quick(arguments):
    """Seconds of the processor, the best of several, so that a busy machine does not count."""
    best = float("inf")
    for _ in range(10):
        started = _children_seconds()
        done = run("-m", "ipcli", *arguments, "--help")
        best = min(best, _children_seconds() - started)
        assert done.returncode == 0, done.stderr
        if best < HELP_SECONDS:
            break
    assert best < HELP_SECONDS


def _children_seconds():
    """Of all child processes that have ended; on Windows, which does not tell, the time of day."""
    times = os.times()
    return times.children_user + times.children_system if os.name != "nt" else time.perf_counter()


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_no_two_options_of_a_command_share_a_name_and_all_have_help(name):
    command = cli.load(name)
    names = [option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)]
    assert len(set(names)) == len(names)
    assert command.help
    assert all(parameter.help for parameter in command.params if isinstance(parameter, click.Option))


def test_the_console_scripts_are_those_of_the_table():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    table = {name: name.replace("-", "_") for name, command in cli.COMMANDS.items() if command.is_script}
    assert scripts == {"ipcli": "ipcli.cli.main:main"} | {
        name: f"ipcli.cli.main:{entry}" for name, entry in table.items()
    }
    for name, entry in table.items():
        assert getattr(cli, entry).args == (name,)


@pytest.mark.parametrize("name", [name for name, command in cli.COMMANDS.items() if command.is_script])
def test_every_console_script_has_a_page(name):
    assert (ROOT / "docs" / f"{name}.md").is_file()


def test_the_readme_names_every_command_and_every_exit_code():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `?([\w-]+)`?(?: \*)? \|", text, flags=re.MULTILINE)
    assert {*cli.COMMANDS, "0", "1", "2", "3", "130"} <= set(rows)


def test_the_page_of_the_formats_is_up_to_date():
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    assert page == schema.markdown(), "run python tools/make_formats.py"


def functions(path):
    return [node for node in ast.walk(tree(path)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]


def code_lines(function, lines):
    """Lines of the body that are neither blank nor comment nor docstring; nested functions count."""
    first = function.body[1] if ast.get_docstring(function) and len(function.body) > 1 else function.body[0]
    body = lines[first.lineno - 1 : function.end_lineno]
    return sum(1 for line in body if line.strip() and not line.strip().startswith("#"))


@each_module
def test_modules_and_functions_are_short(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 400
    assert max((code_lines(function, lines) for function in functions(path)), default=0) <= 60


def test_most_functions_are_very_short():
    sizes = [code_lines(f, path.read_text(encoding="utf-8").splitlines()) for path in MODULES for f in functions(path)]
    assert statistics.median(sizes) <= 10
    assert statistics.quantiles(sizes, n=10)[-1] <= 30


@each_module
def test_every_module_and_public_function_says_what_it_is_for(path):
    module = tree(path)
    assert ast.get_docstring(module) or not module.body
    if floor(name_of(path)) != "cli":  # a command's docstring is its help
        public = (
            node for node in module.body if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name[0] != "_"
        )
        assert [node.name for node in public if not ast.get_docstring(node)] == []


@each_module
def test_names_say_what_a_module_holds(path):
    assert not {"utils", "util", "helpers", "helper", "manager", "base", "common", "misc"} & set(
        path.relative_to(ROOT).with_suffix("").parts
    )
