"""Plots as SVG: survival by bearing, fragility curves, and the axes that all plots share."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, floor, hypot, inf, isfinite, log10, pi, sin
from textwrap import wrap
from typing import TYPE_CHECKING, Final

from stackdsl.report.studies import half_text, settings_text
from stackdsl.viewing.svg import BLUE, FAINT, GREEN, GRID, GROUND, INK, RED, Point, encoded, svg_of, text_at, width_of
from stackdsl.wording import bearing_text, how_many, significant, survived_text

if TYPE_CHECKING:
    from stackdsl.judging.proofs import Survival
    from stackdsl.studies.fragility_curve import CurvePoint, Fragility
    from stackdsl.studies.large_motion import FollowedMotion

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


TITLE, ANSWER = 17.0, 13.0  # [px] sizes of a title and of the line below it


def titles(title: str, *answers: str) -> Iterator[str]:
    """Yield the title of a plot, and below it the answer, a sentence on each line."""
    yield text_at(24, 30, title, colour=INK, font_size=f"{TITLE:g}", font_weight="600")
    for number, answer in enumerate(answers):
        yield text_at(24, 50 + 16 * number, answer, colour=FAINT, font_size=f"{ANSWER:g}")


# A fragility curve: points with their intervals, and the lognormal curve, dashed if its test refuses it.


WIDE, HIGH = 640.0, 390.0  # [px]; lines below the title add to the height
SMOOTH = 80  # points of the drawn curve
WIDEST = 90  # [characters] of a line below the title
LABELS = {"acceleration": "constant horizontal acceleration", "tilt": "constant tilt"}  # of axes
PADDING = 0.03  # of the range of the points, beyond its ends


def drawn_fragility(name: str, fragility: "Fragility", suffix: str) -> bytes:
    """Return a plot of a fragility curve as `.svg` or `.png`. Raises ModuleNotFoundError without resvg for `.png`."""
    unit, shown = fragility.intensity.shown_unit, fragility.intensity.shown
    known = [point for point in fragility.points if point.count > point.unknown]
    values = [shown(point.value) for point in known]
    logarithmic = min(values) > 0.0 and not fragility.intensity.is_steady  # engineers draw accelerations linearly
    across = Axis(*_padded(min(values), max(values), logarithmic), 76, WIDE - 28, logarithmic)
    answers = _fragility_answer(fragility)
    height = HIGH + 16 * len(answers)
    up = Axis(0.0, 1.0, height - 60, 64 + 16 * len(answers))
    x_title = LABELS.get(fragility.intensity.kind, fragility.intensity.name) + (f" [{unit}]" if unit else "")
    x_title += ", logarithmic scale" * across.logarithmic
    shapes = [*titles(name, *answers), *grid_of(across, up, x_title, "share of samples that fall")]
    if fragility.fit is not None:
        shapes.append(_curve(fragility, known, across, up))
    shapes += [half] if (half := _half_marked(fragility, across, up)) else []
    for value, point in zip(values, known, strict=True):
        x, low, high = across.place(value), up.place(point.within.low), up.place(point.within.high)
        bar = f"M{x:.1f} {low:.1f}V{high:.1f}M{x - 4:.1f} {low:.1f}h8M{x - 4:.1f} {high:.1f}h8"
        shapes.append(f'<path d="{bar}" stroke="{BLUE}" stroke-width="1.5" fill="none"/>')
        shapes.append(f'<circle cx="{x:.1f}" cy="{up.place(point.share):.1f}" r="4" fill="{BLUE}"/>')
    bars = f"bars: {100.0 * fragility.confidence:g} % interval of each point"
    bars += "; band: where half of the samples fall" * bool(half)
    shapes.append(text_at(WIDE - 28, height - 8, bars, "end"))
    wide = 48.0 + max(WIDE - 48.0, width_of(name, TITLE), *(width_of(answer, ANSWER) for answer in answers))
    return encoded(svg_of(wide, height, shapes), suffix)


def _padded(least: float, largest: float, logarithmic: bool) -> tuple[float, float]:
    """Return ends of an axis a little beyond the first and last value, so that no mark lies on the edge."""
    if logarithmic:
        beyond = (largest / least) ** PADDING
        return least / beyond, largest * beyond
    beyond = PADDING * (largest - least)
    return least - beyond, largest + beyond


def _fragility_answer(fragility: "Fragility") -> list[str]:
    """Return the lines below the title: where half fall, whether the curve is lognormal, and the settings."""
    test, curve = fragility.test, f"no lognormal curve: {fragility.no_curve}"
    if fragility.refused is not None:
        curve = f"dashed: no lognormal curve, the best fit is {fragility.no_curve}"
    elif fragility.curve is not None and test is not None:
        curve = f"line: lognormal curve, not refused, {test.text(fragility.intensity.told(test.at))}"
    texts = [half_text(fragility), curve, settings_text(fragility)]
    if fragility.fell_built:
        texts.append(f"{how_many(fragility.fell_built, 'sample')} fell during the build, counted as fallen everywhere")
    return [line for text in texts for line in wrap(text, WIDEST)]


def _half_marked(fragility: "Fragility", across: Axis, up: Axis) -> str:
    """Return a mark of the intensity at which half of the samples fall, and a band over its interval."""
    within, half = fragility.half_within, fragility.half if fragility.intensity.is_steady else None
    if fragility.curve is not None and not fragility.fell_built:
        within, half = fragility.curve.median_within, fragility.curve.median
    if within is None:
        return ""
    shown = fragility.intensity.shown
    low, high = (across.place(min(max(shown(end), across.least), across.largest)) for end in (within.low, within.high))
    y, foot, head = up.place(0.5), up.place(0.0), up.place(1.0)
    line = f"H{high:.1f}" if half is None else f"H{across.place(shown(half)):.1f}V{foot:.1f}"
    return (
        f'<rect x="{low:.1f}" y="{head:.1f}" width="{high - low:.1f}" height="{foot - head:.1f}" fill="{BLUE}" '
        f'fill-opacity=".12"/><path d="M{across.begin:.1f} {y:.1f}{line}" stroke="{INK}" stroke-dasharray="4 3" '
        'fill="none"/>'
    )


def _curve(fragility: "Fragility", known: Sequence["CurvePoint"], across: Axis, up: Axis) -> str:
    low, high = known[0].value, known[-1].value
    steps = [number / SMOOTH for number in range(SMOOTH + 1)]
    values = [low * (high / low) ** part if across.logarithmic else low + part * (high - low) for part in steps]
    shares = [(across.place(fragility.intensity.shown(v)), fragility.share(v)) for v in values]
    points = " ".join(f"{x:.1f},{up.place(share):.1f}" for x, share in shares if share is not None)
    dashed = ' stroke-dasharray="6 4"' if fragility.refused is not None else ""
    return f'<polyline points="{points}" fill="none" stroke="{INK}" stroke-width="1.5"{dashed}/>'


# A motion by finite displacements: the thrust of supports that move, or the factor on loads that push over.


def drawn_motion(found: "FollowedMotion", suffix: str) -> bytes:
    """Return a plot of a motion as `.svg` or `.png`. Raises ModuleNotFoundError without resvg for `.png`."""
    from stackdsl.report.large_motion import ending_text  # noqa: PLC0415 -- numpy, which other plots do without

    of_loads = found.pushed == "loads"
    points = [(found.movement(p.amount), p.factor if of_loads else found.thrust(p)) for p in found.motion.positions]
    answers = wrap(ending_text(found), WIDEST)
    height = HIGH + 16 * len(answers)
    values = [value for _, value in points] or [0.0]
    across = Axis(0.0, max((movement for movement, _ in points), default=0.0) * (1.0 + PADDING), 76, WIDE - 28)
    up = Axis(min(0.0, *values), max(*values, 0.0) * (1.0 + PADDING), height - 60, 64 + 16 * len(answers))
    x_title = "displacement of the loads along themselves [mm]" if of_loads else f"movement of supports [{found.unit}]"
    shapes = [*titles(found.case, *answers)]
    shapes += grid_of(across, up, x_title, "factor on the loads" if of_loads else "largest horizontal thrust [N]")
    line = " ".join(f"{across.place(x):.1f},{up.place(y):.1f}" for x, y in points)
    shapes.append(f'<polyline points="{line}" fill="none" stroke="{BLUE}" stroke-width="2"/>')
    for before, after in pairwise(found.motion.positions):
        if {(h.lower, h.upper) for h in before.hinges} != {(h.lower, h.upper) for h in after.hinges}:
            x, y = found.movement(after.amount), after.factor if of_loads else found.thrust(after)
            shapes.append(f'<circle cx="{across.place(x):.1f}" cy="{up.place(y):.1f}" r="4" fill="{BLUE}"/>')
    if points and found.motion.falls < inf:
        x, y = points[-1]
        shapes.append(f'<circle cx="{across.place(x):.1f}" cy="{up.place(y):.1f}" r="5" fill="{RED}"/>')
    wide = 48.0 + max(WIDE - 48.0, width_of(found.case, TITLE), *(width_of(answer, ANSWER) for answer in answers))
    return encoded(svg_of(wide, height, shapes), suffix)


# The survived acceleration by bearing, as a polar plot.


SIDE = 520.0  # [px]
RADIUS = 180.0  # [px] of the largest ring
MIDDLE = (SIDE / 2.0, 290.0)  # [px]
AXES: Final = {"+x": 0.0, "+y": pi / 2.0, "-x": pi, "-y": 1.5 * pi}
BETWEEN_AXES: Final = tuple(pi / 16.0 + pi / 8.0 * number for number in range(16))  # bearings of labels [rad]
APART = 4.0  # [px] distance of a label from lines and other labels
SPACING = 3.0  # [px] of the points that stand for a line


def drawn_survival(name: str, survival: "Survival", suffix: str, expected: float | None = None) -> bytes:
    """Return a plot of survival by bearing as `.svg` or `.png`; `expected` is the least value that is expected [g].

    Raises ModuleNotFoundError without resvg for `.png`.
    """
    values = [each.survived for each in survival.along if isfinite(each.survived)]
    largest = max([*values, expected or 0.0]) or 1.0
    rings = [value for value in Axis(0.0, largest * 1.05, 0.0, RADIUS).ticks() if value > 0.0]
    radius = Axis(0.0, max(rings[-1], largest), 0.0, RADIUS)
    corners = [_at(radius.place(min(each.survived, radius.largest)), each.bearing) for each in survival.along]
    polygon = f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in corners)}"'
    labels = _Labels(_between([*corners, corners[0]]))
    weakest = survival.worst
    toward = bearing_text(weakest.bearing)
    answer = f"survives {survived_text(weakest.survived)} g in every direction, weakest towards {toward}"
    shapes = [*titles(name, answer if weakest.survived < inf else "nothing gives way in any direction")]
    limit = None if expected is None else radius.place(expected)
    colour, met = (GREEN, "") if expected is None or weakest.survived >= expected else (RED, ", not met")
    if limit is not None:  # what is missing stays uncovered
        shapes += [_circle(limit, f'fill="{RED}" fill-opacity=".2"'), f'{polygon} fill="{GROUND}"/>']
    shapes += [_circle(radius.place(value), f'fill="none" stroke="{GRID}"') for value in rings]
    for label, bearing in AXES.items():
        (x, y), end = _at(RADIUS, bearing), _at(RADIUS + 18.0, bearing)
        shapes.append(f'<path d="M{MIDDLE[0]} {MIDDLE[1]}L{x:.1f} {y:.1f}" stroke="{GRID}"/>')
        shapes.append(labels.placed([end], label, INK))
    shapes.append(f'{polygon} fill="{BLUE}" fill-opacity=".14" stroke="{BLUE}" stroke-width="2"/>')
    if limit is not None:
        shapes.append(_circle(limit, f'fill="none" stroke="{colour}" stroke-width="1.5" stroke-dasharray="6 4"'))
        labels.keep_off(_between([_at(limit, pi * degree / 180.0) for degree in range(361)]))
    if weakest.survived < inf:
        x, y = mark = _at(radius.place(weakest.survived), weakest.bearing)
        shapes.append(f'<path d="M{MIDDLE[0]} {MIDDLE[1]}L{x:.1f} {y:.1f}" stroke="{INK}" stroke-width="1.5"/>')
        shapes.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{INK}"/>')
        labels.keep_off(_between([MIDDLE, mark]))
        around = [weakest.bearing + pi / 8.0 * turn for turn in (0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7)]
        near = [(x + (16 + 3 * off) * cos(b), y - off * sin(b)) for off in (14.0, 20.0, 30.0) for b in around]
        shapes.append(labels.placed(near, f"{survived_text(weakest.survived)} g", INK, "600"))
    if limit is not None and expected is not None:
        near = [_at(limit + off, bearing) for off in (16.0, -16.0, 30.0, -30.0) for bearing in BETWEEN_AXES]
        shapes.append(labels.placed(near, f"expected: {significant(expected)} g{met}", colour, "600"))
    texts = [f"{significant(value)} g" for value in rings]
    ways = [[_at(radius.place(value), bearing) for value in rings] for bearing in BETWEEN_AXES]
    free = [[labels.room(*label) >= APART for label in zip(way, texts, strict=True)] for way in ways]
    clearest = max(range(len(ways)), key=lambda way: sum(free[way]))
    named = zip(ways[clearest], texts, free[clearest], strict=True)
    shapes += [labels.placed([at], text) for at, text, is_free in named if is_free]
    shapes.append(text_at(24, SIDE + 4, "radius: horizontal acceleration up to which it is proven to stand"))
    return encoded(svg_of(max(SIDE, width_of(name, TITLE) + 48.0), SIDE + 20, shapes), suffix)


def _at(radius: float, bearing: float) -> Point:
    """Return the position of a bearing, seen from above with +y up [px]."""
    return MIDDLE[0] + radius * cos(bearing), MIDDLE[1] - radius * sin(bearing)


def _circle(radius: float, style: str) -> str:
    return f'<circle cx="{MIDDLE[0]}" cy="{MIDDLE[1]}" r="{radius:.1f}" {style}/>'


def _between(corners: Sequence[Point]) -> Iterator[Point]:
    """Yield points along a line through corners, which stand for it."""
    for (x, y), (to_x, to_y) in pairwise(corners):
        count = ceil(hypot(to_x - x, to_y - y) / SPACING)
        yield from ((x + (to_x - x) * part / count, y + (to_y - y) * part / count) for part in range(count))


class _Labels:
    """Labels that keep off lines and other labels."""

    def __init__(self, taken: Iterable[Point]) -> None:
        self._taken = list(taken)

    def keep_off(self, points: Iterable[Point]) -> None:
        """Keep later labels off these points."""
        self._taken += points

    def room(self, middle: Point, text: str) -> float:
        """Return the distance from the box of a label to the nearest point taken [px]."""
        half = width_of(text) / 2.0
        x, y = middle
        return min(hypot(max(abs(px - x) - half, 0.0), max(abs(py - y) - 7.0, 0.0)) for px, py in self._taken)

    def placed(self, middles: Sequence[Point], text: str, colour: str = FAINT, weight: str = "400") -> str:
        """Return a label at the first of these positions with room, or at the one with the most."""
        rooms = [self.room(middle, text) for middle in middles]
        x, y = (
            next((at for at, room in zip(middles, rooms, strict=True) if room >= APART), None)
            or max(zip(rooms, middles, strict=True))[1]
        )
        half = width_of(text) / 2.0
        self.keep_off(_between([(x - half, y), (x + half, y), (x - half, y)]))
        halo = {"stroke": GROUND, "stroke_width": "4", "paint_order": "stroke", "stroke_linejoin": "round"}
        return text_at(x, y + 4, text, "middle", colour, font_size="13", font_weight=weight, **halo)
