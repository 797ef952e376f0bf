"""What a long benchmark measured so far, in a file: a run that was killed goes on where it was."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any


class Memory:
    """Results by their keys, a line of JSON each; a line that was cut off by a kill is left out. Delete the file to
    measure anew, as after a change of what is measured.
    """

    def __init__(self, path: Path):
        self.path, self.known = path, dict[str, Any]()
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True) if path.exists() else []
        for line in lines:
            if line.endswith("\n"):
                key, value = json.loads(line)
                self.known[_name(key)] = value
        if lines and not lines[-1].endswith("\n"):
            path.write_text("".join(lines[:-1]), encoding="utf-8")

    def recall(self, key: list[Any], work: Callable[[], Any]) -> Any:
        """What is known by this key; if nothing is, what `work` returns, all of it JSON, which is kept."""
        name = _name(key)
        if name not in self.known:
            self.known[name] = work()
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps([key, self.known[name]]) + "\n")
                file.flush()
                os.fsync(file.fileno())
        return self.known[name]


def _name(key: list[Any]) -> str:
    return json.dumps(key, sort_keys=True)
