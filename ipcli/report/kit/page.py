"""One self-contained HTML page: elements that escape what they are given, figures, tables, and the frame around them.

Nothing is fetched and nothing runs: pictures are data URIs, plots are inline SVG, the style is in the page, and there
is no script.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from urllib.parse import quote

from ipcli.report.kit.numbers import number, with_unit
from ipcli.report.kit.pictures import Picture, Scale, strip
from ipcli.report.kit.style import CSS

VOID = {"img", "meta", "br"}


class Markup(str):
    """Text that is HTML already. Every other string is escaped when it becomes part of an element."""


def element(tag: str, *children: object, **attributes: object) -> Markup:
    """An element; children and attributes are escaped. ``class_`` is class, ``a_b`` is a-b, None leaves out."""
    names = {name: name.rstrip("_") if name.endswith("_") else name.replace("_", "-") for name in attributes}
    written = "".join(
        f' {names[name]}="{escape(str(value))}"' for name, value in attributes.items() if value is not None
    )
    opening = f"<{tag}{written}>"
    return Markup(opening) if tag in VOID else Markup(f"{opening}{join(*children)}</{tag}>")


def join(*children: object) -> Markup:
    """Children one after the other, those that are no Markup escaped."""
    return Markup("".join(child if isinstance(child, Markup) else escape(str(child)) for child in children))


def page(title: str, eyebrow: str, verdict: object, *parts: Markup) -> str:
    """The whole document: a small line, the title, a sentence that says how it went, and the sections."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("title", title),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("style", Markup(CSS)),
    )
    header = element(
        "header", element("p", eyebrow, class_="eyebrow"), element("h1", title), element("p", verdict, class_="verdict")
    )
    return f"<!doctype html>\n{element('html', head, element('body', element('main', header, *parts)), lang='en')}\n"


def section(title: str, *parts: Markup, lead: object = "") -> Markup:
    """A titled part of the page; ``lead`` is the sentence under the title that says how to read it."""
    return element("section", element("h2", title), element("p", lead, class_="lead") if lead else "", *parts)


WIDE = 6  # columns, beyond which a table is set closer
TURNED = element("a", "X.turn.html", href="X.turn.html")  # the page beside this one in which a surface can be turned


def with_turning_page(html: str, name: str | None) -> str:
    """The page with the links of TURNED leading to the file of that name, or mere words for None."""
    link = element("a", name, href=quote(name)) if name else Markup("X.turn.html")
    return html.replace(TURNED, link)


def notice(text: object) -> Markup:
    """A line that a reader should not miss."""
    return element("p", element("strong", "Note: "), text, class_="notice", role="note")


def figure(
    picture: Picture,
    caption: object,
    note: object = "",
    *,
    scale: Scale | None = None,
    crisp: bool = False,
    frame: tuple[float, float, float, float] | None = None,
) -> Markup:
    """A picture with its caption, a smaller note, and its colour bar if ``scale`` is given.

    ``crisp`` shows single pixels when enlarged; ``frame`` marks a part: left, top, width, height as shares of it.
    """
    shown = element(
        "img",
        src=picture.uri,
        width=picture.width,
        height=picture.height,
        alt=caption,
        class_="crisp" if crisp else None,
    )
    places = zip(("left", "top", "width", "height"), frame or (), strict=False)
    mark = (
        element("i", class_="frame", style=";".join(f"{side}:{100 * share:.2f}%" for side, share in places))
        if frame
        else ""
    )
    words = element("figcaption", element("b", caption), element("span", note) if note else "")
    return element("figure", element("div", shown, mark, class_="picture"), bar(scale) if scale else "", words)


def bar(scale: Scale) -> Markup:
    """A colour bar with its limits, some values between them, and the unit behind the last."""
    values = scale.ticks()
    texts = [number(values[0], 4), *(number(value) for value in values[1:-1]), with_unit(values[-1], scale.unit, 4)]
    places = [f"left:{100 * float(scale.position(value)):.2f}%" for value in values]
    labels = [element("span", text, style=place) for text, place in zip(texts, places, strict=True)]
    ramp = element("img", src=strip(scale).uri, alt=f"colour bar from {texts[0]} to {texts[-1]}")
    return element("div", ramp, element("div", *labels, class_="ticks"), class_="bar")


def gallery(*figures: Markup, columns: int, small: bool = False) -> Markup:
    """Figures in a grid of at most ``columns``; fewer on a narrow screen."""
    return element("div", *figures, class_="gallery small" if small else "gallery", style=f"--columns:{columns}")


def columns_for(aspect: float, count: int, *, small: bool = False) -> int:
    """How many pictures of that aspect (width over height) go side by side, so that wide ones stay legible."""
    most = (8 if small else 3) if aspect < 1.9 else (4 if small else 2)
    return max(2, min(most, count))


def table(
    columns: Sequence[object],
    rows: Sequence[Sequence[object]],
    *,
    bold: Collection[tuple[int, int]] = (),
    warn: Mapping[int, str] | None = None,
) -> Markup:
    """A table, names in its first column; many columns are set closer. ``bold`` cells are (row, column); ``warn`` maps
    marked rows to a tooltip.
    """
    warn = warn or {}
    head = element("tr", *(element("th", column, scope="col") for column in columns))
    body = [
        element(
            "tr",
            *(_cell(cell, column, (row, column) in bold) for column, cell in enumerate(cells)),
            class_="warn" if row in warn else None,
            title=warn.get(row),
        )
        for row, cells in enumerate(rows)
    ]
    whole = element("table", element("thead", head), element("tbody", *body))
    return element("div", whole, class_="scroll dense" if len(columns) > WIDE else "scroll")


def _cell(content: object, column: int, bold: bool) -> Markup:
    content = element("strong", content) if bold else content
    return element("th", content, scope="row") if column == 0 else element("td", content)


def meter(share: float, text: str) -> Markup:
    """A number with a small bar of its share of 1, to be compared down a column."""
    filled = element("i", style=f"width:{100 * min(max(share, 0.0), 1.0):.1f}%") if share == share else ""
    return element(
        "span", element("span", filled, class_="track"), element("span", text, class_="value"), class_="meter"
    )


def details(summary: str, *parts: Markup) -> Markup:
    """A block that opens on demand."""
    return element("details", element("summary", summary), *parts)
