"""The closing sections that every page shares: what it was made from, and with which parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from json import dumps
from typing import Any

from ipcli.report.kit.page import Markup, details, element, section, table


def origin(provenance: Mapping[str, Any]) -> Markup:
    """Parameters and inputs of an artefact, folded away; an artefact without a record says so."""
    if not provenance:
        return section("Origin", lead="The artefact carries no record of its parameters and inputs.")
    command, version, digest = (str(provenance.get(key, "unknown")) for key in ("command", "ipcli", "digest"))
    lead = _with_code("Made by ", command, f" of ipcli {version}, seed {provenance.get('seed', 0)}; digest ", digest)
    return section(
        "Origin", _parameters(provenance.get("params") or {}), _inputs(provenance.get("inputs") or []), lead=lead
    )


def _with_code(*texts: str) -> Markup:
    """Texts in turn plain and set as code."""
    return element("span", *(element("code", text) if index % 2 else text for index, text in enumerate(texts)))


def leaves(params: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    """The leaves of nested parameters as (dotted name, value), sorted: artefacts keep no order of keys."""
    for name, value in sorted(params.items()):
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _parameters(params: Mapping[str, Any]) -> Markup:
    rows = [
        (name, element("code", value if isinstance(value, str) else dumps(value))) for name, value in leaves(params)
    ]
    return details(f"Parameters ({len(rows)})", element("div", table(("Parameter", "Value"), rows), class_="text"))


def _inputs(inputs: list[Mapping[str, str]]) -> Markup:
    rows = [(entry["name"], element("code", entry["sha256"])) for entry in inputs]
    return details(f"Inputs ({len(rows)})", element("div", table(("Input", "SHA-256"), rows), class_="text"))
