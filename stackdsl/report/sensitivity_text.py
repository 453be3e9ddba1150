"""What margins depend on most, as text, CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any, Final

from stackdsl.finding.sensitivities import Effect, Of, Sensitivities, Source

FORMAT = 1  # of the JSON; raised when something in it changes its meaning
UNITS: Final = {Of.ACCELERATION: "g", Of.FRICTION: ""}
HOW: Final = {
    Source.CHECKED: "differences say so too",
    Source.DUALS: "not held against differences",
    Source.DIFFERENCES: "by differences alone",
    Source.NONE: "there is no margin on either side",
}
COLUMNS: Final = ("case", "margin", "what", "unit", "size", "less", "more", "by_a_hundredth", "kink", "source")


def sensitivity_lines(found: Sensitivities, most: int) -> Iterator[str]:
    """The margin, and a line for each number that it depends on, the most first."""
    yield found.case
    unit = UNITS[found.of]
    what = "least friction" if found.of is Of.FRICTION else "acceleration"
    yield f"  {what} {found.margin:.4g} {unit}".rstrip() + "; by a hundredth of each number it changes by up to:"
    shown = [each for each in found.effects if each.counts][:most]
    width = max((len(each.what) for each in shown), default=0)
    for each in shown:
        yield f"    {each.what:<{width}}  {each.matters:>10.3g} {unit:<1}  {_slopes(each, unit)}; {HOW[each.source]}"
    rest = sum(each.counts for each in found.effects) - len(shown)
    if rest:
        yield f"    and {rest} more"
    nothing = [each for each in found.effects if not each.counts]
    if nothing:
        by_forces = sum(each.source is Source.DUALS for each in nothing)
        checked = ", none of them held against differences" if by_forces == len(nothing) else ""
        unchecked = checked or (f", {by_forces} of them not held against differences" if by_forces else "")
        yield f"    {len(nothing)} of {len(found.effects)} numbers do not matter{unchecked}"
    if found.in_doubt:
        yield "    forces or motions are not unique at the limit: what is not checked may be off; --check N checks more"
    if found.judged < found.bricks:
        yield f"  of {found.judged} of {found.bricks} bricks: from there on an engine has a word, which is not asked"


def _slopes(effect: Effect, unit: str) -> str:
    per = f" {unit}/{effect.unit}" if unit and effect.unit else (f" {unit}" if unit else f" 1/{effect.unit}")
    per = per if unit or effect.unit else ""
    if not effect.has_kink:
        assert effect.more is not None
        return f"{effect.more:+.4g}{per}"
    less, more = ("no margin" if each is None else f"{each:+.4g}{per}" for each in (effect.less, effect.more))
    return f"{less} below and {more} above"


def sensitivity_csv(found: Sequence[Sensitivities]) -> str:
    """A row a number."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for each in found:
        writer.writerows({"case": each.case, "margin": each.margin, **_row(effect)} for effect in each.effects)
    return out.getvalue()


def sensitivity_json(found: Sequence[Sensitivities]) -> dict[str, Any]:
    """The same as JSON; `null` where there is no margin on a side."""
    return {"format": FORMAT, "cases": [*map(_case, found)]}


def _case(found: Sensitivities) -> dict[str, Any]:
    told = {"case": found.case, "of": found.of, "margin": found.margin, "in_doubt": found.in_doubt}
    return {**told, "effects": [*map(_row, found.effects)]}


def _row(effect: Effect) -> dict[str, Any]:
    return {
        **{"what": effect.what, "unit": effect.unit, "size": effect.size, "less": effect.less, "more": effect.more},
        **{"by_a_hundredth": effect.matters, "kink": effect.has_kink, "source": effect.source},
    }
