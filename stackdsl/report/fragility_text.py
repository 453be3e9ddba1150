"""A fragility curve as text, CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any

from stackdsl.judging.fragility import Fragility, Point
from stackdsl.judging.shares import Interval
from stackdsl.sampling.intensities import SHAKING

FORMAT = 1  # of the JSON; raised when something in it changes its meaning
PERCENT = 100.0
COLUMNS = ("value", "unit", "fell", "unknown", "samples", "share", "low", "high", "decided")


def fragility_lines(name: str, fragility: Fragility) -> Iterator[str]:
    """Points, curve, and what is to be said of both."""
    yield name
    unit, sure = fragility.intensity.shown_unit, f"{PERCENT * fragility.confidence:.6g} %"
    heading = f"{fragility.intensity.name}{f' [{unit}]' if unit else ''}"
    yield f"  {heading:>20}  share that falls, and between which it lies ({sure})"
    for point in fragility.points:
        yield f"  {_number(fragility, point.value):>20}  {_share(point)}  {_counts(point)}"
    yield from (f"  {line}" for line in _curve_lines(fragility, unit, sure))
    judged = sum(point.count for point in fragility.points)
    if fragility.intensity.kind in SHAKING and fragility.points:
        judged = fragility.points[0].count
    if judged:
        each = 1000.0 * fragility.cpu_time / judged
        yield f"  {judged} verdicts in {fragility.cpu_time:.2f} s of all processors, {each:.3g} ms each"


def _curve_lines(fragility: Fragility, unit: str, sure: str) -> Iterator[str]:
    curve = fragility.curve
    if fragility.fell_built:
        yield f"{fragility.fell_built} samples fell while they were built; the curve is of the others"
    if curve is None:
        yield f"no lognormal curve: {fragility.no_curve}"
    else:
        median, dispersion = _between(fragility, curve.median_within), _plain(curve.dispersion_within)
        how = "" if curve.rises else ", and fewer fall at more"
        yield (
            f"lognormal: median {_number(fragility, curve.median)} {unit}".rstrip()
            + f" ({median}), dispersion {curve.dispersion:.4g} ({dispersion}){how}; intervals at {sure}"
        )
    if fragility.half is not None:
        whose = "the samples" if fragility.intensity.kind in SHAKING else "the points"
        yield f"half fall at {_number(fragility, fragility.half)} {unit}".rstrip() + f", by {whose} alone"
    if fragility.left_out:
        yield f"{fragility.left_out} verdicts are open, and the curve is without them"
    if missed := fragility.missed:
        where = ", ".join(_number(fragility, point.value) for point in missed)
        yield f"the curve misses the interval of {len(missed)} of {len(fragility.points)} points: {where}"


def _number(fragility: Fragility, value: float) -> str:
    return f"{fragility.intensity.shown(value):.4g}"


def _share(point: Point) -> str:
    within = point.within
    return f"{PERCENT * point.share:6.2f} %  {PERCENT * within.low:6.2f} .. {PERCENT * within.high:6.2f} %"


def _counts(point: Point) -> str:
    open_ones = f", {point.unknown} open" if point.unknown else ""
    return f"{point.fell:>6} of {point.count}{open_ones}  ({_decided(point)})"


def _decided(point: Point) -> str:
    return ", ".join(f"{count} {way}" for way, count in sorted(point.ways.items(), key=lambda each: -each[1]))


def _between(fragility: Fragility, within: Interval) -> str:
    return f"{_number(fragility, within.low)} .. {_number(fragility, within.high)}"


def _plain(within: Interval) -> str:
    return f"{within.low:.4g} .. {within.high:.4g}"


def fragility_csv(curves: Sequence[tuple[str, Fragility]]) -> str:
    """A row a point."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("case", "over", *COLUMNS))
    for name, fragility in curves:
        for point in fragility.points:
            writer.writerow((name, fragility.intensity.name, *_row(fragility, point).values()))
    return out.getvalue()


def fragility_json(curves: Sequence[tuple[str, Fragility]]) -> dict[str, Any]:
    """The same as JSON, with the curve; `null` where there is none."""
    return {"format": FORMAT, "cases": [{"case": name, **as_values(fragility)} for name, fragility in curves]}


def as_values(fragility: Fragility) -> dict[str, Any]:
    """A fragility curve as plain values."""
    curve = fragility.curve
    fitted = None
    if curve is not None:
        fitted = {
            "median": _rounded(fragility.intensity.shown(curve.median)),
            "median_within": [_rounded(fragility.intensity.shown(end)) for end in _ends(curve.median_within)],
            "dispersion": _rounded(curve.dispersion),
            "dispersion_within": [_rounded(end) for end in _ends(curve.dispersion_within)],
            "rises": curve.rises,
        }
    return {
        "over": fragility.intensity.name,
        "unit": fragility.intensity.shown_unit,
        "seed": fragility.seed,
        "confidence": fragility.confidence,
        "points": [
            {**_row(fragility, point), "decided": dict(sorted(point.ways.items()))} for point in fragility.points
        ],
        "lognormal": fitted,
        "no_lognormal": fragility.no_curve,
        "half": _rounded(fragility.intensity.shown(fragility.half)) if fragility.half is not None else None,
        "fell_built": fragility.fell_built,
        "left_out": fragility.left_out,
        "missed": [_rounded(fragility.intensity.shown(point.value)) for point in fragility.missed],
    }


def _ends(within: Interval) -> tuple[float, float]:
    return within.low, within.high


def _row(fragility: Fragility, point: Point) -> dict[str, Any]:
    share = point.share if point.count > point.unknown else None
    numbers = (point.fell, point.unknown, point.count, share and _rounded(share))
    ends = (_rounded(end) for end in _ends(point.within))
    return dict(
        zip(
            COLUMNS,
            (
                _rounded(fragility.intensity.shown(point.value)),
                fragility.intensity.shown_unit,
                *numbers,
                *ends,
                _decided(point),
            ),
            strict=True,
        )
    )


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
