"""The sheet of a packed load that a person signs: verdict, limits, weakest carton, layers and order of placing.

It is one HTML page without scripts, for a screen and for A4 paper.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from html import escape
from importlib.metadata import version
from math import atan2, degrees, fsum, hypot
from pathlib import Path
from typing import Final

from stability.analysis.load_bounds import loads_on
from stability.analysis.weakest import without_side_friction
from stability.contact_law import OtherLawError
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.compound import parts_of
from stability.geometry.placed_shape import corners_W, part_pose
from stability.geometry.polygons import Point2, Polygon, convex_hull
from stability.model import Vec3
from stability.problem import Problem, Stability
from stability.work_limit import TooMuchWorkError
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import proofs_of
from stackdsl.language.claims.claim_result import placed
from stackdsl.language.claims.pallet_limits import centre_on_deck, in_deck_frame, overhangs
from stackdsl.language.claims.protocol import SIDES
from stackdsl.language.pallets import DECK_BRICK
from stackdsl.results import RunStatus, VariantResult
from stackdsl.studies.survival import CaseMargins
from stackdsl.trace import BrickState, BrickTrack, Trace
from stackdsl.wording import degrees_text, gives_way_text, how_many, limit_text, mm, slides_together

DIGEST: Final = 12  # hexadecimal digits of a digest
AROUND: Final = 0.04  # share of the longer side of the deck that is drawn around it
LABEL, NAME = 0.055, 0.036  # sizes of text as shares of this side
LEVEL: Final = 1e-6  # [m] between heights of one surface
ROUNDING: Final = 1e-9  # [m]
RIGHT_ANGLE, SQUARE = 90.0, 0.01  # [deg], and a turn that counts as none
PROVEN, DISPROVEN = Stability.STABLE.value, Stability.UNSTABLE.value
MOST_CARRIED: Final = 100  # cartons; the least and the greatest load of one takes tens of milliseconds
LETTER: Final = 0.62  # width of a letter as a share of its height

STYLE: Final = """
:root { --ink: #1b1d20; --soft: #565b62; --line: #c9c9c1; --pass: #17683f; --fail: #b3261e; --open: #7a4b00; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 900px; padding: 24px; color: var(--ink); background: #fff;
  font: 14px/20px "Segoe UI", "Helvetica Neue", "Liberation Sans", Arial, sans-serif; }
h1 { margin: 0; font-size: 24px; line-height: 30px; } h2 { margin: 24px 0 8px; font-size: 16px; line-height: 22px; }
p { margin: 4px 0; } .soft, th { color: var(--soft); }
table { width: 100%; border-collapse: collapse; } th { text-align: left; font-weight: 600; }
th, td { padding: 3px 12px 3px 0; border-bottom: 1px solid var(--line); vertical-align: top; overflow-wrap: anywhere; }
th, td:first-child { white-space: nowrap; }
td.number, th.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
tr.failed td { color: var(--fail); font-weight: 600; }
.verdict { margin: 16px 0; padding: 10px 14px; border: 2px solid; border-radius: 4px;
  font-size: 18px; line-height: 26px; font-weight: 600; }
.passed { color: var(--pass); } .failed { color: var(--fail); } .open { color: var(--open); }
.facts { display: grid; grid-template-columns: max-content 1fr; gap: 2px 16px; margin: 0; }
.facts dt { color: var(--soft); } .facts dd { margin: 0; overflow-wrap: anywhere; }
.layers { display: grid; grid-template-columns: repeat(auto-fill, minmax(260px, 1fr)); gap: 16px; }
figure { margin: 0; break-inside: avoid; } figcaption { font-weight: 600; }
svg { display: block; width: 100%; height: auto; }
.signatures { display: grid; grid-template-columns: repeat(3, 1fr); gap: 24px; margin-top: 56px; break-inside: avoid; }
.signatures div { border-top: 1px solid var(--ink); padding-top: 4px; color: var(--soft); }
@media (max-width: 520px) { body { padding: 12px; } table { display: block; overflow-x: auto; }
  .facts, .signatures { grid-template-columns: 1fr; }
  .facts dd { margin-bottom: 6px; } .signatures { gap: 48px; } }
@page { size: A4; margin: 15mm; }
@media print { body { max-width: none; padding: 0; font-size: 10pt; line-height: 14pt; }
  .layers { grid-template-columns: repeat(2, 1fr); } h2 { break-after: avoid; }
  thead { display: table-header-group; } tr { break-inside: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
"""


@dataclass(frozen=True, slots=True)
class _Carton:
    """A carton of the load in the frame of its deck."""

    number: int  # in the order of placing, from 1
    track: BrickTrack
    layer: int  # from 1
    low: Vec3  # lower corner of its bounds, from the corner of the deck and its top [m]
    size: Vec3  # of its bounds [m]
    outline: Polygon  # in plan [m]


@dataclass(frozen=True, slots=True)
class _Load:
    """The load on its deck, or on the ground if there is no deck."""

    cartons: Sequence[_Carton]
    deck: BrickTrack | None
    boards: Sequence[Sequence[Point2]]  # outlines of the surface of the deck [m]
    area: tuple[float, float]  # length and width of the deck, or of the load [m]


def sheet_page(case: Case, trace: Trace, result: VariantResult, margins: CaseMargins, made: datetime) -> str:
    """Return the page of a load. `made` is the time that it shows."""
    load = _load_of(trace)
    title = f"Load sheet: {case.name}" if case.variant.parameters else f"Load sheet: {case.scenario_name}"
    parts = (
        f"<h1>{escape(title)}</h1>",
        f'<p class="soft">{escape(case.scenario.description or "")}</p>',
        _verdict(result, margins, len(load.cartons)),
        "<h2>The load</h2>",
        _facts(_figures(case, load, margins)),
        "<h2>Limits</h2>",
        _limits(result),
        "<h2>Layers</h2>",
        f'<div class="layers">{"".join(_layers(load))}</div>',
        "<h2>Order of placing</h2>",
        _order(load),
        "<h2>Basis</h2>",
        _facts(_basis(case, load, made)),
        '<div class="signatures"><div>Packed by</div><div>Checked by</div><div>Place and date</div></div>',
    )
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
    head += f"<title>{escape(title)}</title>"
    return (
        f'<!doctype html><html lang="en"><head>{head}<style>{STYLE}</style></head><body>{"".join(parts)}</body></html>'
    )


def _load_of(trace: Trace) -> _Load:
    tracks = list(placed(trace))
    deck = next((track for track in tracks if track.brick.id == DECK_BRICK), None)
    others = [track for track in tracks if track is not deck]
    boards: list[Sequence[Point2]] = []
    if deck is None:
        points = [corner for track in others for corner in corners_W(track.brick.shape, track.placed)]
        (ax, bx), (ay, by) = ((min(along), max(along)) for along in list(zip(*points, strict=True))[:2])
        shift, area = (ax, ay, 0.0), (bx - ax, by - ay)
    else:
        own = [in_deck_frame(deck, corner) for corner in corners_W(deck.brick.shape, deck.final)]
        half_x, half_y, top = (max(along) for along in zip(*own, strict=True))
        shift, area = (-half_x, -half_y, top), (2.0 * half_x, 2.0 * half_y)
        surface = [outline for outline, high in _surfaces(deck) if abs(high - top) <= LEVEL]
        boards = [[(x + half_x, y + half_y) for x, y in each] for each in surface]
    cartons = []
    for number, track in enumerate(others, 1):
        corners = [
            _moved(in_deck_frame(deck, c) if deck else c, shift) for c in corners_W(track.brick.shape, track.placed)
        ]
        lows, highs = zip(*((min(along), max(along)) for along in zip(*corners, strict=True)), strict=True)
        size = (highs[0] - lows[0], highs[1] - lows[1], highs[2] - lows[2])
        outline = convex_hull([(x, y) for x, y, _ in corners])
        layer = track.level - (1 if deck is not None else 0)
        cartons.append(_Carton(number, track, layer, (lows[0], lows[1], lows[2]), size, outline))
    return _Load(cartons, deck, boards, area)


def _moved(point: Vec3, origin: Vec3) -> Vec3:
    return (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])


def _surfaces(deck: BrickTrack) -> Iterator[tuple[Polygon, float]]:
    """Yield the outline of each part of a deck in its frame, and the height of its top [m]."""
    for part in parts_of(deck.brick.shape):
        points = [in_deck_frame(deck, corner) for corner in corners_W(part.shape, part_pose(part, deck.final))]
        yield convex_hull([(x, y) for x, y, _ in points]), max(z for *_, z in points)


def _verdict(result: VariantResult, margins: CaseMargins, cartons: int) -> str:
    failed = [outcome for outcome in result.outcomes if not outcome.passed]
    proven = margins.verdict == PROVEN
    word = "failed" if failed or margins.verdict == DISPROVEN or result.status is not RunStatus.DONE else "passed"
    word = word if proven or word == "failed" else "open"
    stands = f"{how_many(cartons, 'carton')} proven to stand" if proven else f"Not proven to stand: {margins.why}"
    if not result.outcomes:
        limits = "no limit is given"
    else:
        count = len(result.outcomes)
        limits = f"all {count} limits are met" if not failed else f"{len(failed)} of {count} limits are not met"
    return f'<p class="verdict {word}">{escape(stands)}; {escape(limits)}.</p>'


def _figures(case: Case, load: _Load, margins: CaseMargins) -> Iterator[tuple[str, str]]:
    tracks = [carton.track for carton in load.cartons]
    mass = fsum(track.brick.mass for track in tracks)
    top = max((carton.low[2] + carton.size[2] for carton in load.cartons), default=0.0)
    layers = how_many(max((carton.layer for carton in load.cartons), default=0), "layer")
    yield "Cartons", f"{len(tracks)} in {layers}, {mass:.6g} kg"
    deck = load.deck
    if deck is not None:
        height = max(in_deck_frame(deck, corner)[2] for corner in corners_W(deck.brick.shape, deck.final))
        surface = f"{len(load.boards)} boards" if len(load.boards) > 1 else "closed deck"
        size = f"{mm(load.area[0])} x {mm(load.area[1])} x {mm(height)}"
        yield "Pallet", f"{size}, {surface}, {deck.brick.mass:.6g} kg"
        yield "Gross", f"{mass + deck.brick.mass:.6g} kg, {mm(top + height)} high"
        beyond, side, name = max(overhangs(deck, tracks)) if tracks else (0.0, "", "")
        told = f"{mm(beyond)} by {name} towards {side}" if beyond > ROUNDING else "none"
        yield "Overhang", told
        x, y, z = centre_on_deck(deck, tracks) if tracks else (0.0, 0.0, 0.0)
        place = f"{mm(hypot(x, y))} from the middle of the deck ({mm(x)} along, {mm(y)} across)"
        yield "Centre of mass", f"{place}, {mm(z)} above the floor"
    else:
        yield "Height", mm(top)
    if margins.acceleration is not None and margins.tilt is not None:
        yield (
            "Survives",
            f"{limit_text(margins.acceleration)} g in every direction, a tilt of {degrees(margins.tilt):.3g} deg",
        )
    if margins.unaided is not None:
        yield "Without friction between neighbours", f"{limit_text(margins.unaided)} g"
    if margins.used_strength is not None:
        apart = f"; without friction between neighbours, {margins.crushes_apart}" if margins.crushes_apart else ""
        yield "Strength", f"the cartons need {100.0 * margins.used_strength:.4g} % of their strength{apart}"
    if margins.verdict == PROVEN and (carried := _carries_most(case, [track.brick.id for track in tracks])):
        yield "Carries most", carried
    if (weakest := margins.weakest) is not None:
        when = f"above {limit_text(weakest.acceleration)} g towards {degrees_text(weakest.bearing)}"
        first = "no single carton" if slides_together(weakest) else weakest.brick
        yield "Weakest", f"{first}: {when}, {gives_way_text(weakest)}"


def _carries_most(case: Case, cartons: Sequence[str]) -> str:
    """Return the carton with the greatest proven load, and its mean pressure; empty if no load is computed."""
    if not 1 < len(cartons) <= MOST_CARRIED:
        return ""
    assembly = proofs_of(case.timeline).assembly
    problem, names = assembly.problem(), [name for name in cartons if name in assembly.bricks]
    apart = without_side_friction(problem)
    try:
        carried = _most_carried(problem, names, assembly.gravity)
        alone = "" if apart is None or not carried else _most_carried(apart, names, assembly.gravity)
    except (OtherLawError, TooMuchWorkError):
        return ""
    return f"{carried}; without friction between neighbours, {alone}" if alone else carried


def _most_carried(problem: Problem, cartons: Sequence[str], gravity: float) -> str:
    """Say which carton has the greatest proven load, and its mean pressure; empty if the cartons may not stand."""
    loads = loads_on(problem, cartons)
    if not loads:
        return ""
    name, most = max(loads.items(), key=lambda each: each[1].greatest.force)
    pressure = "" if most.pressure is None else f", {max(most.pressure) / 1000.0:.3g} kPa on average"
    return f"{name}: at most {most.greatest.force / gravity:.4g} kg{pressure}"


def _limits(result: VariantResult) -> str:
    rows = [
        (
            "" if outcome.passed else ' class="failed"',
            (
                outcome.name.replace("_", " "),
                _permitted(outcome.expected),
                _by_direction(outcome.measured) if outcome.name == "protocol" else outcome.measured,
                "met" if outcome.passed else "NOT met",
            ),
        )
        for outcome in result.outcomes
    ]
    if not rows:
        return "<p>The scenario has no claims, so nothing is limited.</p>"
    head = "".join(f"<th>{name}</th>" for name in ("limit", "permitted", "measured", "result"))
    body = "".join(f"<tr{mark}>{''.join(f'<td>{_lines(cell)}</td>' for cell in cells)}</tr>" for mark, cells in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _permitted(expected: str) -> str:
    """Return a limit without the key `is`, and with the number of bricks in place of many names."""
    names = re.search(r"\bbricks (\S+(?: [^\s,]+){3,})", expected)
    text = expected if names is None else expected.replace(names[0], f"for {len(names[1].split())} cartons")
    return text.removeprefix("is ")


def _by_direction(measured: str) -> str:
    """Return the results of a protocol with one direction on each line."""
    return re.sub(rf"[,;] (?=(?:{'|'.join(SIDES)}) )", "\n", measured)


def _lines(text: str) -> str:
    return escape(text).replace("\n", "<br>")


def _layers(load: _Load) -> Iterator[str]:
    """Yield a picture of each layer from above, with the layer below in grey."""
    by_layer: defaultdict[int, list[_Carton]] = defaultdict(list)
    for carton in load.cartons:
        by_layer[carton.layer].append(carton)
    points = [point for carton in load.cartons for point in carton.outline] + [(0.0, 0.0), load.area]
    (ax, bx), (ay, by) = ((min(along), max(along)) for along in zip(*points, strict=True))
    long = max(bx - ax, by - ay)
    around = AROUND * long
    box = f"{ax - around:.4f} {-by - around:.4f} {bx - ax + 2 * around:.4f} {by - ay + 2 * around:.4f}"
    deck = [_polygon(each, "#e8dcc3", "#a08a5f", long) for each in load.boards]
    if not load.boards:
        (x, y), floor = load.area, "#f1f1ec"
        deck = [_polygon([(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)], floor, "#c9c9c1", long)]
    for layer in sorted(by_layer):
        below = [_polygon(each.outline, "#d9d9d3", "#8d8d86", long) for each in by_layer.get(layer - 1, ())]
        own = [_drawn(each, long) for each in by_layer[layer]]
        mass = fsum(each.track.brick.mass for each in by_layer[layer])
        caption = f"Layer {layer}: {how_many(len(own), 'carton')}, {mass:.6g} kg"
        title = f"Plan of layer {layer}: cartons {', '.join(each.track.brick.id for each in by_layer[layer])}"
        svg = f'<svg viewBox="{box}" role="img" aria-label="{escape(title)}">{"".join((*deck, *below, *own))}</svg>'
        yield f"<figure><figcaption>{caption}</figcaption>{svg}</figure>"


def _polygon(points: Sequence[Point2], fill: str, edge: str, long: float) -> str:
    """Return a polygon; y points up on the page."""
    placed_at = " ".join(f"{x:.4f},{-y:.4f}" for x, y in points)
    return f'<polygon points="{placed_at}" fill="{fill}" stroke="{edge}" stroke-width="{0.003 * long:.5f}"/>'


def _drawn(carton: _Carton, long: float) -> str:
    """Return a carton with its number, and its name where it fits."""
    x, y = carton.low[0] + 0.5 * carton.size[0], -(carton.low[1] + 0.5 * carton.size[1])
    fallen = carton.track.state is BrickState.FALLEN
    shape = _polygon(carton.outline, "#f3b5ae" if fallen else "#d8bd92", "#4d4536", long)
    name, label, small = carton.track.brick.id, LABEL * long, NAME * long
    has_name = LETTER * small * len(name) <= carton.size[0] and 1.3 * (label + small) <= carton.size[1]
    number = _text(str(carton.number), x, y if has_name else y + 0.35 * label, label, ' font-weight="700"')
    return shape + number + (_text(name, x, y + 1.1 * small, small) if has_name else "")


def _text(text: str, x: float, y: float, size: float, more: str = "") -> str:
    return f'<text x="{x:.4f}" y="{y:.4f}" font-size="{size:.4f}" text-anchor="middle"{more}>{escape(text)}</text>'


def _order(load: _Load) -> str:
    origin = (
        "from the corner of the deck and its top"
        if load.deck is not None
        else "from the corner of the load and the ground"
    )
    names = ("no.", "carton", "layer", "x mm", "y mm", "z mm", "size as it lies, mm", "kg")
    head = "".join(f"<th{'' if name == 'carton' else NUMBER}>{name}</th>" for name in names)
    rows = []
    for each in load.cartons:
        x, y, z = (_plain(part) for part in each.low)
        size = _size(each, load.deck)
        cells = (str(each.number), each.track.brick.id, str(each.layer), x, y, z, size, f"{each.track.brick.mass:.6g}")
        marks = ("" if name == "carton" else NUMBER for name in names)
        cells_ = "".join(f"<td{mark}>{escape(cell)}</td>" for mark, cell in zip(marks, cells, strict=True))
        rows.append(f"<tr{_fallen(each)}>{cells_}</tr>")
    note = f'<p class="soft">x, y, z is the lower corner of the space that a carton takes, {origin}.</p>'
    return f"{note}<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


NUMBER: Final = ' class="number"'


def _size(carton: _Carton, deck: BrickTrack | None) -> str:
    """Return the sides of a carton as it lies [mm], or its own sides and its turn if it lies askew."""
    shape, turned = carton.track.brick.shape, _yaw(carton.track) - (0.0 if deck is None else _yaw(deck))
    askew = abs(turned - RIGHT_ANGLE * round(turned / RIGHT_ANGLE)) > SQUARE
    if not askew or not isinstance(shape, Box | OffCentreBox):
        return " x ".join(_plain(side) for side in carton.size)
    return f"{' x '.join(_plain(side) for side in shape.size)}, turned {turned % 360.0:.3g} deg"


def _yaw(track: BrickTrack) -> float:
    """Return the turn of an upright brick about the vertical [deg]."""
    *_, z, w = track.placed.orientation
    return degrees(2.0 * atan2(z, w))


def _fallen(carton: _Carton) -> str:
    return ' class="failed"' if carton.track.state is BrickState.FALLEN else ""


def _plain(length: float) -> str:
    """Return a length in millimetres without its unit, to a hundredth."""
    return f"{round(1000.0 * length, 2) + 0.0:.10g}"


def _basis(case: Case, load: _Load, made: datetime) -> Iterator[tuple[str, str]]:
    yield "Scenario", _with_digest(case.source.file)
    for part in case.source.parts:
        yield "Read from", _with_digest(part)
    yield "Friction", f"{case.scenario.friction:g} between cartons, unless a carton or the ground has its own"
    yield "Judged by", f"exact statics of rigid bodies, StackDSL {version('stackdsl')}, system {case.system}"
    yield "Not covered", "straps, film, bulging, crushing of corners, and the strength of the pallet"
    yield "Made", f"{made:%Y-%m-%d %H:%M} UTC"


def _with_digest(path: str) -> str:
    """Return the name of a file with the beginning of its SHA-256, so that another version is noticed."""
    try:
        digest = sha256(Path(path).read_bytes()).hexdigest()[:DIGEST]
    except OSError:
        return Path(path).name
    return f"{Path(path).name} (SHA-256 {digest}...)"


def _facts(facts: Iterator[tuple[str, str]]) -> str:
    return (
        f'<dl class="facts">{"".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in facts)}</dl>'
    )
