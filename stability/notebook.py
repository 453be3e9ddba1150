"""Results as notebooks show them: a status, a title and labelled lines, as text and as HTML."""

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from functools import singledispatch
from html import escape
from typing import TYPE_CHECKING, Final, NoReturn, Protocol

# Text on these stands out in light and in dark notebooks: at least 6.5:1.
GROUNDS: Final = {True: "#17683f", False: "#b3261e", None: "#565b62"}
UNPRINTABLE: Final = "\ufffd"  # stands for a control character, which a terminal may obey

_BADGE: Final = "color: #ffffff; padding: 1px 8px; border-radius: 4px; white-space: nowrap"
_GRID: Final = "display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: 2px 16px; margin-top: 4px"
_TEXT: Final = "overflow-wrap: anywhere"
_ALIGNED: Final = (
    "margin: 4px 0 0; white-space: pre-wrap; word-break: normal; overflow-wrap: anywhere; line-height: 1.4; "
    "font-family: var(--jp-code-font-family, ui-monospace, monospace)"
)


@dataclass(frozen=True, slots=True)
class Display:
    """The text of a value in a notebook: title, status and lines."""

    title: str
    lines: Sequence[tuple[str, str]] = ()  # label and text
    word: str = ""  # status, such as `✓ passed`
    good: bool | None = None  # colour of the status; None for neither good nor bad
    aligned: Sequence[str] = ()  # lines whose columns stand below each other
    more: Callable[[], str] = str  # returns HTML to show below, which has no text and may take long to make

    @property
    def text(self) -> str:
        """Return the text for notebooks without HTML, and for IPython in a terminal."""
        width = max((len(label) for label, _ in self.lines), default=0)
        rows = [f"  {label:<{width}}  {text}" for label, text in self.lines]
        head = "  ".join(filter(None, (self.word, self.title)))
        return "\n".join(map(_printable, (head, *rows, *self.aligned)))

    @property
    def html(self) -> str:
        """Return the HTML. Texts are never markup."""
        ground = f"background: {GROUNDS[self.good]}"
        badge = f'<span style="{_BADGE}; {ground}">{escape(self.word)}</span> ' if self.word else ""
        rows = "".join(
            f'<div><b>{escape(label)}</b></div><div style="{_TEXT}">{escape(text)}</div>' for label, text in self.lines
        )
        grid = f'<div style="{_GRID}">{rows}</div>' if rows else ""
        aligned = f'<pre style="{_ALIGNED}">{escape(chr(10).join(self.aligned))}</pre>' if self.aligned else ""
        head = f"{badge}<b>{escape(self.title)}</b>"
        return f'<div style="margin: 4px 0 12px; {_TEXT}">{head}{grid}{aligned}{self.more()}</div>'


def _printable(text: str) -> str:
    return "".join(character if character.isprintable() else UNPRINTABLE for character in text)


@singledispatch
def display_of(value: object) -> Display:
    """Return what a notebook shows of a value; modules that know the words of a type register it."""
    raise NotImplementedError  # notebooks show the `repr` then


def bundle(displays: Sequence[Display], include: Container[str] | None = None) -> dict[str, str]:
    """Return values below each other by media type; `include` has the types that are wanted, None for all."""
    told = {"text/plain": "\n".join(each.text for each in displays)}
    if include is None or "text/html" in include:
        told["text/html"] = "".join(each.html for each in displays)
    return told


class Printer(Protocol):
    """The pretty printer of IPython."""

    def text(self, text: str) -> object:
        """Print a text."""


class Displayed:
    """A value that notebooks show by `display_of`."""

    __slots__ = ()

    def _repr_mimebundle_(self, include: Container[str] | None = None, exclude: object = None) -> dict[str, str]:
        """Return the value as text and as HTML, for notebooks; the HTML only if it is wanted."""
        return bundle([display_of(self)], include)

    if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which has the names of all attributes."""
            names = [] if name.startswith("_") else [each for each in dir(type(self)) if not each.startswith("_")]
            has = f"; choose from: {', '.join(names)}" if names else ""
            kind = type(self).__name__
            raise AttributeError(f"'{kind}' object has no attribute '{name}'{has}", name=name, obj=self)


class Printed(Displayed):
    """A value that `print` shows as the text of a notebook."""

    __slots__ = ()

    def __str__(self) -> str:
        """Return the lines that a notebook shows."""
        return display_of(self).text
