"""Plots as SVG: survival by bearing, fragility curves, and the axes that all plots share."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, cos, degrees, floor, inf, isfinite, log10, pi, sin
from typing import TYPE_CHECKING, Final

from stackdsl.report.text import significant
from stackdsl.wording import rounded_down

if TYPE_CHECKING:
    from stackdsl.judging.proofs import Survival
    from stackdsl.studies.fragility_curve import CurvePoint, Fragility

# Axes, and the frame of a plot with its title, ticks and labels.


ABOUT = 6  # ticks
ROUND = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis from a least to a largest value, between two positions [px]."""

    least: float
    largest: float
    begin: float
    end: float
    logarithmic: bool = False

    def place(self, value: float) -> float:
        """Return the position of a value [px]; the middle if the axis has only one value."""
        value, least, largest = (log10(v) if self.logarithmic else v for v in (value, self.least, self.largest))
        part = (value - least) / (largest - least) if largest > least else 0.5
        return self.begin + part * (self.end - self.begin)

    def ticks(self) -> Iterator[float]:
        """Yield about six round values within the axis; powers of ten if these are enough."""
        if self.logarithmic:
            yield from self._logarithmic_ticks()
            return
        wide = self.largest - self.least
        if wide <= 0.0:
            yield self.least
            return
        power = 10.0 ** floor(log10(wide / ABOUT))
        step = next(factor * power for factor in ROUND if factor * power * ABOUT >= wide * (1.0 - 1e-9))
        rounding = 1e-9 * wide
        for number in range(ceil((self.least - rounding) / step), floor((self.largest + rounding) / step) + 1):
            yield number * step

    def _logarithmic_ticks(self) -> Iterator[float]:
        powers = range(floor(log10(self.least)), ceil(log10(self.largest)) + 1)
        every = max(1, ceil(len(powers) / ABOUT))
        factors = (1.0, 2.0, 5.0) if len(powers) <= ABOUT // 2 else (1.0,)
        for power in powers[::every]:
            for factor in factors:
                if self.least * (1.0 - 1e-9) <= factor * 10.0**power <= self.largest * (1.0 + 1e-9):
                    yield factor * 10.0**power


# Colours have a contrast of at least 3 to the white ground, which a plot also has on a dark page.
INK, FAINT, GRID, BLUE, RED, GROUND = "#1b1d20", "#4b4f55", "#d5d5cd", "#1a56b0", "#b3261e", "#ffffff"
FONT: Final = "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif"


def text_at(x: float, y: float, text: str, anchor: str = "start", colour: str = FAINT, **style: str) -> str:
    """Return a text at a position [px]."""
    more = "".join(f' {name.replace("_", "-")}="{value}"' for name, value in style.items())
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}"{more}>{escape(text)}</text>'


def svg_of(width: float, height: float, shapes: Iterable[str]) -> str:
    """Return an SVG with a ground of its own, readable on light and dark pages."""
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="{FONT}" font-size="12">'
    return "\n".join([head, f'<rect width="100%" height="100%" fill="{GROUND}"/>', *shapes, "</svg>"]) + "\n"


def grid_of(across: Axis, up: Axis, x_title: str, y_title: str, below: float = 0.0) -> Iterator[str]:
    """Yield grid lines, ticks and titles of two axes; the labels of the first stand `below` its lines [px]."""
    for value in across.ticks():
        x = across.place(value)
        yield f'<path d="M{x:.1f} {up.begin:.1f}V{up.end:.1f}" stroke="{GRID}"/>'
        yield text_at(x, up.begin + below + 16, significant(value), "middle")
    for value in up.ticks():
        y = up.place(value)
        yield f'<path d="M{across.begin:.1f} {y:.1f}H{across.end:.1f}" stroke="{GRID}"/>'
        yield text_at(across.begin - 6, y + 4, significant(value), "end")
    yield text_at((across.begin + across.end) / 2, up.begin + 36, x_title, "middle", INK)
    yield text_at(across.begin - 40, up.end - 12, y_title, "start", INK)


def titles(title: str, answer: str) -> Iterator[str]:
    """Yield the title of a plot, and below it the answer in one sentence."""
    yield text_at(24, 30, title, colour=INK, font_size="17", font_weight="600")
    yield text_at(24, 50, answer, colour=FAINT, font_size="13")


def encoded(svg: str, suffix: str) -> bytes:
    """Return a plot as `.svg` or `.png`. Raises ModuleNotFoundError without resvg, which `.png` needs."""
    if suffix.lower() == ".svg":
        return svg.encode()
    from stackdsl.viewing.pictures import png  # noqa: PLC0415 -- an optional extra

    return png(svg)


# A fragility curve: points with their intervals, and the lognormal curve if it fits them.


WIDE, HIGH = 640.0, 420.0  # [px]
SMOOTH = 80  # points of the drawn curve
MOST_MISSED = 0.2  # share of the points whose interval a drawn curve may miss


def drawn_fragility(name: str, fragility: "Fragility", suffix: str) -> bytes:
    """Return a plot of a fragility curve as `.svg` or `.png`. Raises ModuleNotFoundError without resvg for `.png`."""
    unit, shown = fragility.intensity.shown_unit, fragility.intensity.shown
    known = [point for point in fragility.points if point.count > point.unknown]
    values = [shown(point.value) for point in known]
    across = Axis(min(values), max(values), 76, WIDE - 28, logarithmic=min(values) > 0.0)
    up = Axis(0.0, 1.0, HIGH - 60, 96)
    x_title = f"{fragility.intensity.name} [{unit}]" if unit else fragility.intensity.name
    shapes = [*titles(name, _fragility_answer(fragility)), *grid_of(across, up, x_title, "share of samples that fall")]
    if fragility.curve is not None and not _misfits(fragility):
        shapes.append(_curve(fragility, known, across, up))
    for value, point in zip(values, known, strict=True):
        x, low, high = across.place(value), up.place(point.within.low), up.place(point.within.high)
        bar = f"M{x:.1f} {low:.1f}V{high:.1f}M{x - 4:.1f} {low:.1f}h8M{x - 4:.1f} {high:.1f}h8"
        shapes.append(f'<path d="{bar}" stroke="{BLUE}" stroke-width="1.5" fill="none"/>')
        shapes.append(f'<circle cx="{x:.1f}" cy="{up.place(point.share):.1f}" r="4" fill="{BLUE}"/>')
    bars = f"bars: intervals of {100.0 * fragility.confidence:g} % for each point"
    shapes.append(text_at(WIDE - 28, HIGH - 8, bars, "end"))
    return encoded(svg_of(WIDE, HIGH, shapes), suffix)


def _misfits(fragility: "Fragility") -> bool:
    """Return whether the lognormal curve misses too many points to be drawn."""
    return len(fragility.missed) > MOST_MISSED * len(fragility.points)


def _fragility_answer(fragility: "Fragility") -> str:
    if fragility.curve is None:
        return f"no curve is drawn: {fragility.no_curve}"
    if _misfits(fragility):
        missed, count = len(fragility.missed), len(fragility.points)
        return f"the lognormal curve misses {missed} of {count} points and is not drawn"
    return f"half of the samples fall at {fragility.intensity.told(fragility.curve.median)}; line: lognormal curve"


def _curve(fragility: "Fragility", known: Sequence["CurvePoint"], across: Axis, up: Axis) -> str:
    low, high = known[0].value, known[-1].value
    steps = [number / SMOOTH for number in range(SMOOTH + 1)]
    values = [low * (high / low) ** part if across.logarithmic else low + part * (high - low) for part in steps]
    shares = [(across.place(fragility.intensity.shown(v)), fragility.share(v)) for v in values]
    points = " ".join(f"{x:.1f},{up.place(share):.1f}" for x, share in shares if share is not None)
    return f'<polyline points="{points}" fill="none" stroke="{INK}" stroke-width="1.5"/>'


# The survived acceleration by bearing, as a polar plot.


SIDE = 520.0  # [px]
RADIUS = 180.0  # [px] of the largest ring
MIDDLE = (SIDE / 2.0, 300.0)  # [px]
RING_BEARING = pi / 8.0  # bearing of the labels of rings [rad]
AXES: Final = {"+x": 0.0, "+y": pi / 2.0, "-x": pi, "-y": 1.5 * pi}


def drawn_survival(name: str, survival: "Survival", suffix: str) -> bytes:
    """Return a plot of survival by bearing as `.svg` or `.png`. Raises ModuleNotFoundError without resvg for `.png`."""
    along = [each for each in survival.along if isfinite(each.survived)]
    largest = max((each.survived for each in along), default=1.0) or 1.0
    rings = [value for value in Axis(0.0, largest * 1.05, 0.0, RADIUS).ticks() if value > 0.0]
    radius = Axis(0.0, max(rings[-1], largest), 0.0, RADIUS)
    weakest = survival.worst
    answer = (
        f"survives {significant(weakest.survived)} g in every direction; weakest towards {_bearing(weakest.bearing)}"
    )
    shapes = [*titles(name, answer if weakest.survived < inf else "nothing gives way in any direction")]
    for value in rings:
        r = radius.place(value)
        shapes.append(f'<circle cx="{MIDDLE[0]}" cy="{MIDDLE[1]}" r="{r:.1f}" fill="none" stroke="{GRID}"/>')
    for label, bearing in AXES.items():
        (x, y), (far_x, far_y) = _at(RADIUS, bearing), _at(RADIUS + 18.0, bearing)
        shapes.append(f'<path d="M{MIDDLE[0]} {MIDDLE[1]}L{x:.1f} {y:.1f}" stroke="{GRID}"/>')
        shapes.append(text_at(far_x, far_y + 4, label, "middle", INK, font_size="13"))
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in (_at(radius.place(each.survived), each.bearing) for each in along))
    shapes.append(f'<polygon points="{line}" fill="{BLUE}" fill-opacity=".14" stroke="{BLUE}" stroke-width="2"/>')
    for value in rings:  # above the area
        x, y = _at(radius.place(value), RING_BEARING)
        box = (
            f'<rect x="{x - 20:.1f}" y="{y - 9:.1f}" width="40" height="16" rx="3" fill="{GROUND}" fill-opacity=".85"/>'
        )
        shapes += [box, text_at(x, y + 4, f"{significant(value)} g", "middle")]
    if weakest.survived < inf:
        shapes += _marked(weakest.bearing, radius.place(weakest.survived), f"{rounded_down(weakest.survived)} g")
    shapes.append(text_at(24, SIDE + 24, "radius: horizontal acceleration up to which it is proven to stand"))
    return encoded(svg_of(SIDE, SIDE + 40, shapes), suffix)


def _at(radius: float, bearing: float) -> tuple[float, float]:
    """Return the position of a bearing, seen from above with +y up [px]."""
    return MIDDLE[0] + radius * cos(bearing), MIDDLE[1] - radius * sin(bearing)


def _marked(bearing: float, radius: float, text: str) -> Iterator[str]:
    """Yield a mark of the weakest direction, with its value outside of the rings."""
    (x, y), (end_x, end_y), (text_x, text_y) = (
        _at(radius, bearing),
        _at(RADIUS + 8.0, bearing),
        _at(RADIUS + 36.0, bearing),
    )
    yield f'<path d="M{x:.1f} {y:.1f}L{end_x:.1f} {end_y:.1f}" stroke="{RED}" stroke-dasharray="3 3"/>'
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{RED}"/>'
    anchor = "middle" if abs(cos(bearing)) < 0.5 else "start" if cos(bearing) > 0.0 else "end"  # noqa: PLR2004
    yield text_at(text_x - 14.0 * cos(bearing), text_y + 4, text, anchor, RED, font_size="13", font_weight="600")


def _bearing(bearing: float) -> str:
    """Return a bearing by the name of its axis, or in degrees from +x towards +y."""
    angle = degrees(bearing) % 360.0
    named = [label for label, axis in AXES.items() if abs(angle - degrees(axis)) < 0.05]  # noqa: PLR2004
    return named[0] if named else f"{angle:.0f} deg"
