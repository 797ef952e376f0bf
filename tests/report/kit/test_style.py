"""The style sheet is whole, loads nothing, and has every colour that it uses in light and in dark."""

import re

from ipcli.report.kit.style import CSS

DEFINED = re.compile(r"(--[\w-]+):")
USED = re.compile(r"var\((--[\w-]+)\)")


def test_nothing_is_loaded_and_every_bracket_closed():
    assert not re.search(r"url\(|@import|@font-face|expression\(|</", CSS)
    depth = 0
    for character in CSS:
        depth += {"{": 1, "}": -1}.get(character, 0)
        assert depth >= 0
    assert depth == 0
    assert CSS.count("(") == CSS.count(")")


def test_every_colour_in_use_is_there_by_day_and_by_night():
    light = re.search(r":root\{([^}]*)\}", CSS)[1]
    dark = re.search(r"dark\)\{:root\{([^}]*)\}", CSS)[1]
    assert set(DEFINED.findall(light)) == set(DEFINED.findall(dark))
    assert set(USED.findall(CSS)) - {"--columns"} <= set(DEFINED.findall(light))  # columns: set by each gallery


def luminance(colour):
    """Relative luminance of #rrggbb (WCAG 2)."""
    channels = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_text_can_be_read_by_day_and_by_night():
    """Contrast of 4.5 or more: level AA of WCAG 2."""
    for pattern in (r":root\{([^}]*)\}", r"dark\)\{:root\{([^}]*)\}"):
        colours = dict(re.findall(r"(--[\w-]+):(#[0-9a-f]{6})", re.search(pattern, CSS)[1]))
        for text, ground in (("ink", "paper"), ("soft", "paper"), ("soft", "card"), ("alarm", "alarm-card")):
            one, other = sorted((luminance(colours[f"--{name}"]) for name in (text, ground)), reverse=True)
            assert (one + 0.05) / (other + 0.05) >= 4.5, (text, ground)
