"""Write docs/formats.md from the schema: `python tools/make_formats.py`."""

from pathlib import Path

from ipcli import schema
from ipcli.io.files import atomic

if __name__ == "__main__":
    atomic.write_text(Path(__file__).resolve().parent.parent / "docs" / "formats.md", schema.markdown())
