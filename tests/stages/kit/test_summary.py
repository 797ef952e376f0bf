"""The name of a result always, and its figures where it is."""

from pathlib import Path

from ipcli.stages.kit.summary import of_result


@of_result
def summary(output: Path) -> dict[str, int]:
    """How many letters it has."""
    return {"letters": len(output.read_text())}


def test_figures_come_after_the_name_of_what_is_there(tmp_path):
    (tmp_path / "a.txt").write_text("abc")
    assert summary(tmp_path / "a.txt") == {"output": tmp_path / "a.txt", "letters": 3}
    assert next(iter(summary(tmp_path / "a.txt"))) == "output"
    assert summary.__doc__ == "How many letters it has."


def test_of_what_is_not_there_only_the_name_is_told(tmp_path):
    assert summary(tmp_path / "none.txt") == {"output": tmp_path / "none.txt"}
