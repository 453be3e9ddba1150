"""SVG elements that pictures and plots share, and SVG as PNG."""

from collections.abc import Iterable
from functools import cache
from html import escape
from typing import Final, TypeAlias

from stackdsl.viewing.style import token

# Colours of light surroundings, with a contrast of at least 3 to their ground. A browser replaces them in dark ones.
INK, FAINT, GRID, GROUND = token("ink"), token("ink-2"), token("line"), token("surface")
BLUE, GREEN, RED = token("accent"), token("pass"), token("fail")
FONT: Final = "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif"
# resvg takes `sans-serif` for Arial, and draws no text in fonts that are not installed.
FONT_OF_PNG: Final = "{}, {}".format(
    FONT.removesuffix(", sans-serif"),
    "'Helvetica Neue', Helvetica, 'Noto Sans', Roboto, 'Open Sans', Ubuntu, Cantarell, 'DejaVu Sans', sans-serif",
)


Point: TypeAlias = tuple[float, float]  # [px]

WIDE_SIGNS = 0x1100  # code from which on letters are as wide as high, as in Chinese
NARROW, BROAD = frozenset(" !'()*,-./:;I[]fijlrt|"), frozenset("%@MWmw")


def width_of(text: str, size: float = 13.0) -> float:
    """Return about how wide a text is in the sans-serif fonts of a size [px]; rather too wide than too narrow."""
    return size * sum(0.36 if c in NARROW else 0.95 if c in BROAD or ord(c) >= WIDE_SIGNS else 0.6 for c in text)


def text_at(x: float, y: float, text: str, anchor: str = "start", colour: str = FAINT, **style: str) -> str:
    """Return a text at a position [px]."""
    more = "".join(f' {name.replace("_", "-")}="{value}"' for name, value in style.items())
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}"{more}>{escape(text)}</text>'


CLASS: Final = "stackdsl-picture"
# Colours of bricks stay: names on them, and their shades, suit their light colours.
THEMED: Final = (
    *("ink", "ink-2", "line", "surface", "scene", "ground", "grid", "edge", "outline", "accent", "pass", "fail"),
    *("f1", "f2", "f3", "f4", "f5"),
)


@cache
def dark_rules() -> str:
    """Return the CSS rules that replace colours in dark surroundings; a program without style sheets ignores them."""
    rules = "".join(
        f'.{CLASS} [{attribute}="{token(name)}"]{{{attribute}:{token(name, dark=True)}}}'
        for name in THEMED
        for attribute in ("fill", "stroke")
    )
    return f"@media (prefers-color-scheme:dark){{{rules}}}"


def svg_of(width: float, height: float, shapes: Iterable[str], adapts: bool = True) -> str:
    """Return an SVG with a ground of its own; `adapts` is whether its colours follow dark surroundings."""
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    style = f' class="{CLASS}" font-family="{FONT}" font-size="12"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}{style}>{f"<style>{dark_rules()}</style>" if adapts else ""}'
    return "\n".join([head, f'<rect width="100%" height="100%" fill="{GROUND}"/>', *shapes, "</svg>"]) + "\n"


def png(svg: str, zoom: float = 2.0) -> bytes:
    """Return a PNG with `zoom` pixels per SVG pixel along each side. Raises ModuleNotFoundError without resvg."""
    import resvg_py  # noqa: PLC0415 -- an extra

    return bytes(resvg_py.svg_to_bytes(svg_string=svg.replace(FONT, FONT_OF_PNG), zoom=zoom))


@cache
def png_has_text() -> bool:
    """Return whether PNG files show text: whether a font of `FONT_OF_PNG` is installed."""
    return png(svg_of(20, 20, [text_at(0, 15, "M", colour=INK)])) != png(svg_of(20, 20, []))


def encoded(svg: str, suffix: str) -> bytes:
    """Return a plot as `.svg` or `.png`. Raises ModuleNotFoundError without resvg, which `.png` needs."""
    if suffix.lower() == ".svg":
        return svg.encode()
    return png(svg)
