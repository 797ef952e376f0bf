"""One page of a whole demo: a picture and a line of each command, with links to the pages that the commands made.

    python -m tools.make_index [build/demo]

The line is what the command's own page says of its result; the picture is drawn from the artefact.
"""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import atomic, h5
from ipcli.report.gaze.panorama import panorama
from ipcli.report.kit.page import Markup, element, page
from ipcli.report.kit.pictures import photograph
from ipcli.report.mocap.action_recognition import answers_matrix
from ipcli.report.saliency.overlay import glow
from tools import make_pictures as draw

WIDEST = 900
STYLE = (
    ".cards{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:44px 36px}"
    ".cards h2 code{font-size:19px}.cards .shown{display:flex;align-items:center;justify-content:center;height:280px;"
    "margin:12px 0 10px;background:var(--card);border-radius:4px;overflow:hidden}"
    ".cards .shown img{display:block;max-width:100%;max-height:280px;width:auto;height:auto}"
    ".cards .shown svg{max-height:280px}.cards p{margin:6px 0 0}.cards .links a{margin-right:18px}"
    "a{color:var(--accent)}"
    "@media(max-width:900px){.cards{grid-template-columns:minmax(0,1fr)}}"
)

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True)
class Card:
    """What is shown of a command."""

    command: str
    asks: str  # what the command answers
    stem: str  # of the artefact and its pages
    kind: str
    picture: Callable[[Arrays], np.ndarray | Markup]
    shows: str
    note: str = ""
    turns: tuple[tuple[str, str], ...] = ()  # further pages: how their name goes on, and what they are


TURN = (("turn", "to be turned"),)
CARDS = (
    Card("gaze-sfm", "Where did somebody walk, and what did they look at?", "room.gaze", "gaze-experiment", panorama,
         "A room with parcels around the wearer of a head camera; points of regard in red", turns=TURN),
    Card("saliency", "What is likely to be looked at there?", "room.saliency", "saliency", draw.attention,
         "Above, points of regard (red) and predicted proto-objects (green); below, saliency",
         "Learnt from a few seconds: too little to trust its rates. docs/saliency.md has those of long tasks.",
         (*TURN, ("membranes", "membranes at work"))),
    Card("fuse-depth", "What is the depth, when eleven views disagree?", "shapes.fused", "fused-depth", draw.montage,
         "One noisy depth map, the median, the fused map; its confidence, and both surfaces in light"),
    Card("mocap-train", "What do legs and arms do in an action?", "motions.model", "behaviours",
         lambda arrays: draw.behaviours(arrays)[..., ::-1], "Behaviours of kicking, squatting, walking and waving"),
    Card("mocap-classify", "What is somebody new doing?", "motions.recognition", "action-recognition",
         answers_matrix, "Labels of the clips against answers"),
    Card("model-animal", "What solid shape do some pictures show?", "animal", "animal-model", draw.animal,
         "The model from four sides, its parts in colours", turns=TURN),
    Card("brdf-train", "How do materials look under all lights?", "materials", "brdf-library", draw.materials,
         "Each material under six lights"),
    Card("brdf-model", "What surface does one photograph show?", "vase", "brdf-object", draw.object_in_a_photograph,
         "A photograph, the normals found, and the relief under two lamps"),
)  # fmt: skip


def index(folder: Path) -> str:
    """The HTML of a demo's folder. FormatError when an artefact is damaged or not there."""
    cards = [card_of(card, folder) for card in CARDS]
    verdict = (
        "Eight commands have run on the small, generated data of sample_data/. Each has left files, and a page that "
        "says what was found and how well."
    )
    style = element("style", Markup(STYLE))
    grid = element("section", *cards, *predicted(folder), class_="cards")
    return page("What the commands make of the samples", "ipcli · make demo", verdict, style, grid)


def card_of(card: Card, folder: Path) -> Markup:
    """A picture, what is said of it, and links."""
    drawn = card.picture(h5.read(folder / f"{card.stem}.h5", card.kind).arrays)
    return element(
        "div",
        element("h2", element("code", card.command)),
        element("p", card.asks, class_="lead"),
        element("a", shown(drawn, card.shows), href=f"{card.stem}.html"),
        element("p", element("b", f"{card.shows}. "), said(folder / f"{card.stem}.html")),
        element("p", card.note, class_="lead") if card.note else "",
        links(card, folder),
    )


def shown(drawn: np.ndarray | Markup, words: str) -> Markup:
    """A picture (h, w, 3) uint8 or an SVG in its frame."""
    if isinstance(drawn, Markup):
        return element("div", drawn, class_="shown")
    picture = photograph(drawn, WIDEST)
    return element(
        "div",
        element("img", src=picture.uri, width=picture.width, height=picture.height, alt=words),
        class_="shown",
    )


def said(path: Path) -> str:
    """The sentence under the title of a page that a command made."""
    try:
        found = re.search(r'<p class="verdict">(.*?)</p>', path.read_text(encoding="utf-8"), flags=re.DOTALL)
    except OSError as error:
        raise FormatError(path, "is not there", fix="Run make demo") from error
    return html.unescape(re.sub(r"<[^>]*>", "", found[1])) if found else ""


def links(card: Card, folder: Path) -> Markup:
    """To the command's page and to those that can be turned."""
    every = [("", "all that was found"), *((f".{suffix}", words) for suffix, words in card.turns)]
    there = [
        (f"{card.stem}{suffix}.html", words)
        for suffix, words in every
        if (folder / f"{card.stem}{suffix}.html").is_file()
    ]
    return element("p", *(element("a", words, href=name) for name, words in there), class_="links")


def predicted(folder: Path) -> list[Markup]:
    """What `saliency-predict` says of a picture, where the demo has run it."""
    path = folder / "vase.looks.h5"
    if not path.is_file():
        return []
    arrays = h5.read(path, "saliency-maps").arrays
    picture = arrays["pictures/vase/picture"]
    both = np.hstack([picture, glow(picture, arrays["pictures/vase/map"])])
    drawn = shown(both, "A picture, and the same dimmed where people are unlikely to look")
    return [
        element(
            "div",
            element("h2", element("code", "saliency-predict")),
            element("p", "Without gaze and without a scene: where do people look in a picture?", class_="lead"),
            element("a", drawn, href="vase.looks.html"),
            element("p", said(folder / "vase.looks.html")),
        )
    ]


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else draw.DEMO
    atomic.write_text(target / "index.html", index(target))
    print(target / "index.html")
