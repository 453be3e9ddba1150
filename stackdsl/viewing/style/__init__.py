"""The style that all pages share: colours, fonts, buttons and icons."""

import re
from functools import cache
from html import escape
from importlib.resources import files
from typing import Final

ROOM: Final = files(__name__)


@cache
def shared_style() -> str:
    """Return the CSS that all pages share."""
    return (ROOM / "style.css").read_text(encoding="utf-8")


@cache
def token(name: str, dark: bool = False) -> str:
    """Return the colour of a token of `style.css`, such as `wood`, for light or dark surroundings."""
    colours = re.findall(rf"--{name}: (#\w+)", shared_style())  # those for dark follow, where they differ
    return str(colours[-1 if dark else 0])


@cache
def icon_sprite() -> str:
    """Return the hidden SVG that defines the icons of a page; a page has it once."""
    return (ROOM / "icons.svg").read_text(encoding="utf-8")


def icon(name: str, title: str = "") -> str:
    """Return an icon of `icons.svg`; with a title where no word stands beside it."""
    label = f'role="img" aria-label="{escape(title)}"' if title else 'aria-hidden="true"'
    return f'<svg class="icon" {label}><use href="#icon-{name}"/></svg>'
