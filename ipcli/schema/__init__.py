"""Every kind of HDF5 artefact: its fields with dtype, symbolic dims, units and meaning. Checked when written and when
read. `fields` says what a kind is made of, `registry` finds them all; a module for each chapter.
"""

from ipcli.schema.fields import Domain, Field, Kind, SchemaError
from ipcli.schema.registry import CHAPTERS, KINDS, chapter, check_arrays, check_names, kind, markdown, validate

__all__ = [
    "CHAPTERS",
    "KINDS",
    "Domain",
    "Field",
    "Kind",
    "SchemaError",
    "chapter",
    "check_arrays",
    "check_names",
    "kind",
    "markdown",
    "validate",
]
