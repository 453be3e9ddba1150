"""The style that all pages share: colours, fonts, buttons and icons."""

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
def icon_sprite() -> str:
    """Return the hidden SVG that defines the icons of a page; a page has it once."""
    return (ROOM / "icons.svg").read_text(encoding="utf-8")


def icon(name: str, title: str = "") -> str:
    """Return an icon of `icons.svg`; with a title where no word stands beside it."""
    label = f'role="img" aria-label="{escape(title)}"' if title else 'aria-hidden="true"'
    return f'<svg class="icon" {label}><use href="#icon-{name}"/></svg>'
