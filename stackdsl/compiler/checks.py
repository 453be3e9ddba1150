"""Checks of a compiled scenario: names, neighbours, overlaps, slivers, contradictory claims."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Self

from stability.geometry.vectors import SHORTEST
from stability.model import GROUND, BodyId
from stability.statics.assembly import LIGHTEST
from stackdsl.compiler.bricks import MAX_NAMED, ActionOrder, BuiltBrick, WrittenBrick, later_names
from stackdsl.compiler.fit import MOST_INSIDE, CrowdedError, Fit, Sited, fits
from stackdsl.compiler.schedule import Built
from stackdsl.diagnostics import Diagnostic, Span, did_you_mean, first_of
from stackdsl.language.claims.claim import Claim, Expectation
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.schema import Scenario
from stackdsl.language.value_types import NameReference, named_in
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.wording import mm

# Whether every name is that of one brick, and of one that is there to speak of; and whether levels are right.


def lofty_levels(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Levels that the author wrote and that are higher than one above what the brick stands on."""
    for brick in built.bricks:
        if brick.written.level is None or brick.written.of_layout or brick.footing.in_the_air:
            continue  # in the air, a level is the author's word alone
        highest = max((built.bricks[other].level for other in brick.footing.on_boxes), default=0) + 1
        if brick.written.level > highest:
            where = "the ground" if highest == 1 else f"level {highest - 1}"
            message = f"brick '{brick.name}' stands on {where}, so it is no brick of level {brick.written.level}"
            hint = f"write at most {highest}, or leave it out"
            yield Diagnostic("SD104", source.span_of((*brick.written.path, "level")), message, hint)


def shared_names(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are called like an earlier one."""
    first: dict[BodyId, BuiltBrick] = {}
    for brick in built.bricks:
        other = first.setdefault(brick.name, brick)
        if other is not brick:
            there, here = source.span_of(other.written.path), source.span_of(brick.written.path)
            message = f"two bricks are called '{brick.name}'; the other one is at {there.seen_from(here)}"
            yield Diagnostic("SD203", here, message, "give the step or the brick a name")


def shared_with_missiles(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are thrown or dropped and called like another one."""
    taken = {brick.name for brick in built.bricks}
    for number, brick in built.missiles.items():
        if brick.id in taken:
            span = source.span_of(("impacts", number, scenario.impacts[number].kind, "name"))
            yield Diagnostic("SD203", span, f"two bricks are called '{brick.id}'", "give one of them another name")
        taken.add(brick.id)


def unknown_bricks(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that impacts and expectations speak of and that nobody builds, nor throws or drops."""
    names, planes = [brick.name for brick in built.bricks], _planes(scenario)
    bodies = (*names, *(brick.id for brick in built.missiles.values()))
    bricks, all_bodies = set(bodies), {*bodies, *planes}
    impacts = (name for number, impact in enumerate(scenario.impacts) for name in named_in(impact, ("impacts", number)))
    for named in (*impacts, *(named for _, named in _claimed(scenario))):
        if named.name not in (all_bodies if named.or_plane else bricks):
            known = (*bodies, *planes) if named.or_plane else bodies
            hint = did_you_mean(named.name, known) or f"the bricks are called {names[0]} to {names[-1]}"
            yield Diagnostic("SD204", source.span_of(named.path), f"there is no brick '{named.name}'", hint)


def missed_bricks(_built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of at the end, when they are pulled out."""
    gone = {named.name for impact in scenario.impacts for named in impact.done.pulled_out}
    for claim, named in _claimed(scenario):
        if named.name in gone and not claim.stated.allows_removed_bricks:
            message = f"brick '{named.name}' is pulled out, so nothing can be expected of it"
            yield Diagnostic("SD204", source.span_of(named.path), message, "leave it out")


def bricks_that_hit(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that something is expected of as part of the structure, when an impact throws or drops them."""
    comes = {
        built.missiles[number].id: impact.done.missile.how
        for number, impact in enumerate(scenario.impacts)
        if impact.done.missile is not None
    }
    for _, named in _claimed(scenario):
        if named.name in comes and not named.or_plane:
            how = comes[named.name]
            message = f"'{named.name}' is {how}, and no part of the structure; nothing can be expected of it"
            yield Diagnostic(
                "SD204", source.span_of(named.path), message, "leave it out, or name a brick that is built"
            )


def _planes(scenario: Scenario) -> tuple[BodyId, ...]:
    return (GROUND, *(f"wall{number}" for number in range(1, len(scenario.world.walls) + 1)))


def _claimed(scenario: Scenario) -> Iterator[tuple[Claim, NameReference]]:
    """The names of bricks in what is expected and known."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield from ((claim, named) for named in named_in(claim, (key, number)))


# What all claims together ask of a run.


# Unless the scenario or a claim says for how long.
HOLD = 2.0  # [s] watched after the last action
AFTERMATH = 1.0  # [s] a collapse is followed; a plank falls from a metre in less than half of it


@dataclass(frozen=True, slots=True)
class RunRequirements:
    """What a run must show."""

    hold: float  # how long the structure is watched after the last action [s]
    followed: float  # how long a collapse is [s]
    watched: bool  # anything that only motion shows
    margins: tuple[str, ...]  # of the proof, such as `tilt`
    reported_margins: tuple[str, ...]  # the same, where few bricks make them cheap; nothing depends on them
    closely: bool  # how something begins to fall, or where it lands
    measures: tuple[str, ...]  # what is measured only if it is asked for, such as `sway`


def requirements_of(scenario: Scenario) -> RunRequirements:
    """What is expected of the scenario, and known of it, put as what a run must show."""
    claims = [claim.stated for claim in (*scenario.expect, *scenario.truth)]
    spans = [span for span in (scenario.watch, *(claim.needed_hold for claim in claims)) if span is not None]
    return RunRequirements(
        hold=max(spans, default=HOLD),
        followed=scenario.watch or AFTERMATH,
        watched=scenario.watch is not None
        or scenario.world.shake is not None
        or any(step.place is not None for step in scenario.build)
        or any(impact.done.lasts for impact in scenario.impacts)
        or not scenario.expect
        or not all(claim.needs_statics for claim in claims),
        margins=tuple(sorted({margin for claim in claims for margin in claim.needed_margins})),
        reported_margins=tuple(sorted({margin for claim in claims for margin in claim.reported_margins})),
        closely=any(claim.needs_close_looks for claim in claims),
        measures=tuple(sorted({measure for claim in claims for measure in claim.needed_measures})),
    )


# Can everything that is expected of one system come true? What must stand and what must fall cannot be the same.


def contradictions(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Expectations that cannot hold together with an earlier one."""
    levels, hold = {brick.name: brick.level for brick in built.bricks}, requirements_of(scenario).hold
    places = {name: number for number, name in enumerate(levels)}
    meant = [_Meant.of(claim, levels, places, hold) for claim in scenario.expect]
    for number, claim in enumerate(scenario.expect):
        for before, earlier in enumerate(scenario.expect[:number]):
            if not meant[number].excludes(meant[before]):
                continue
            shared = [name for name in scenario.systems if _is_of(claim, name) and _is_of(earlier, name)]
            if shared:
                there = source.key_span_of(("expect", before, earlier.kind))
                here = source.key_span_of(("expect", number, claim.kind))
                which = f"`{earlier.kind}` at {there.seen_from(here)}"
                message = f"this and {which} cannot both hold on {', '.join(shared)}"
                yield Diagnostic("SD104", here, message, "remove one, or say by `system:` what each is expected of")
                break


def beyond_what_is_built(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Claims of more levels, or of more bricks, than there ever are: they would fail, or hold, whatever happens."""
    built_of = {"bricks": len(built.bricks), "levels": built.levels}
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for count in claim.stated.counts():
                most = built_of[count.noun]
                if count.least > most:
                    message = f"{count.least:g} {count.noun} are claimed, and {most} are built"
                    span = source.span_of((key, number, claim.kind, count.key))
                    yield Diagnostic("SD205", span, message, f"claim at most {most}, or build more")


def _is_of(claim: Expectation, system: str) -> bool:
    return claim.system is None or system in claim.system


@dataclass(frozen=True, slots=True)
class _Meant:
    """One claim with what its bricks do by it, worked out once: it is held against every other claim.

    Sets of bricks are numbers with a bit a brick: a thousand claims on ten thousand bricks are not to fill the memory.
    """

    stated: ClaimKind
    alone: int  # bricks each of which is to fall
    together: Sequence[int]  # groups of bricks, of each of which at least one is to fall
    staying: int | None  # bricks that stand; None if it says of none

    @classmethod
    def of(cls, claim: Expectation, levels: Mapping[BodyId, int], places: Mapping[BodyId, int], hold: float) -> Self:
        """What is written under the key of a claim; `places` numbers the bricks."""
        stated, alone, together = claim.stated, set[BodyId](), list[int]()
        for group in stated.must_fall(levels):
            if len(group) == 1:
                alone.update(group)
            else:
                together.append(_bits(group, places))
        staying = stated.must_stand(levels, hold)
        return cls(stated, _bits(alone, places), together, None if staying is None else _bits(staying, places))

    def excludes(self, other: "_Meant") -> bool:
        """Whether both cannot hold."""
        if type(self.stated) is type(other.stated):
            return self.stated.is_apart_from(other.stated)
        return self._takes_away_from(other) or other._takes_away_from(self)

    def _takes_away_from(self, stands: "_Meant") -> bool:
        """Whether this lets something fall that by the other must stand."""
        staying = stands.staying
        if staying is None:
            return False
        return bool(self.alone & staying) or any(group & staying == group for group in self.together)


def _bits(bricks: Collection[BodyId], places: Mapping[BodyId, int]) -> int:
    """A number with a bit for each of some bricks."""
    found = bytearray(len(places) // 8 + 1)
    for brick in bricks:
        place = places[brick]
        found[place >> 3] |= 1 << (place & 7)
    return int.from_bytes(found, "little")


# Bricks that are placed inside others, or in the air.


USUAL_DIGITS, ALL_DIGITS = 4, 17  # of a length in words, and those that tell any two lengths apart


def misfits(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks inside others or in the air; one of a kind for each place in the file, since a layout fails as a whole."""
    told: set[tuple[str, KeyPath]] = set()
    bricks = built.in_order
    try:
        found = fits(_sited(bricks, built), built.planes)
    except CrowdedError as error:
        yield crowded(bricks[error.index].written, source)
        return
    unclear = sum(fit.overlaps for fit in found) > MOST_INSIDE  # what lies on the others
    for brick, fit in zip(bricks, found, strict=True):
        mistake = _misfit(fit, brick, bricks, built) if fit.overlaps or not unclear else None
        if mistake is not None and (mistake[0], brick.written.path) not in told:
            told.add((mistake[0], brick.written.path))
            yield Diagnostic(mistake[0], source.span_of(brick.written.path), *mistake[1:])


def crowded(brick: WrittenBrick, source: Source) -> Diagnostic:
    """That too many bricks lie around one of them to be held against each other."""
    message = "so many bricks lie so close together here that it takes too long to say which of them touch"
    hint = "build fewer, or let long ones lie along the axes: what is compared is what the boxes around them share"
    return Diagnostic("SD206", source.span_of(brick.path), message, hint)


def _sited(bricks: Sequence[BuiltBrick], built: Built) -> list[Sited]:
    """Bricks, each from the moment when it is placed until the one when it is gone."""
    moments = sorted({*(brick.placed for brick in bricks), *built.impacts})
    turns = {moment: float(turn) for turn, moment in enumerate(moments)}
    return [
        Sited(
            turns[brick.placed],
            brick.written.shape,
            brick.written.pose,
            inf if brick.gone is None else turns[brick.gone],
        )
        for brick in bricks
    ]


def _misfit(fit: Fit, brick: BuiltBrick, bricks: Sequence[BuiltBrick], built: Built) -> tuple[str, str, str] | None:
    of_layout = brick.written.of_layout
    if fit.overlaps:
        other = f"brick '{bricks[fit.overlaps_box].name}'" if fit.overlaps_box is not None else ""
        plane = built.planes[fit.overlaps_plane].id if fit.overlaps_plane is not None else ""
        message = f"brick '{brick.name}' is {mm(fit.depth)} inside {other or plane}"
        return "SD201", message, f"move it out by at least {mm(fit.depth)}{', such as by `origin`' * of_layout}"
    if fit.in_the_air and not brick.written.drop:
        above = "" if fit.clearance == inf else f"; the nearest body below is {_distances(fit.clearance, fit.reach)}"
        hint = "place it on something, or say `drop: true` to let it fall"
        if of_layout:
            hint = "give the layout measures with which every brick lies on another, or an `origin` on top of something"
        return "SD202", f"nothing is under brick '{brick.name}'{above}", hint
    return None


def _distances(clearance: float, reach: float) -> str:
    """A distance and the lesser one that it should be, in so many digits that they differ."""
    texts = ((mm(clearance, digits), mm(reach, digits)) for digits in range(USUAL_DIGITS, ALL_DIGITS + 1))
    away, most = next(pair for pair in texts if pair[0] != pair[1])
    return f"{away} away, and what is up to {most} away touches"


# Whether what a brick is placed by is there, and still where the author put it, when the brick comes.


def nowhere(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are placed by one that does not stand before them."""
    lost = [brick for brick in built.bricks if brick.written.lost is not None]
    if not lost:
        return
    later = later_names([brick.written for brick in built.bricks])
    names = [brick.name for brick in built.bricks if brick.written.lost is None]
    for brick in lost:
        error, span = brick.written.lost, _span(brick, source)
        assert error is not None  # as it was looked for
        if error.too_dear:
            message = f"to find '{error.name}' by its place, more than {MAX_NAMED} names have to be worked out anew"
            yield Diagnostic("SD206", span, message, "give the bricks names that others are placed by")
            return
        elif error.name in later:
            there = source.span_of(later[error.name].path)
            message = f"brick '{error.name}' comes only later, at {there.seen_from(span)}"
            yield Diagnostic("SD204", span, message, "name one that is placed before, or place that one first")
        else:
            hint = did_you_mean(error.name, names) or "name one that is placed before"
            yield Diagnostic("SD204", span, f"there is no brick '{error.name}' before this one", hint)


def out_of_place(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that do not fit where they are placed, unless some are placed by what is not there, which says why."""
    moved = first_of(_moved_neighbours(built, scenario, source))
    yield from moved or misfits(built, scenario, source)


def _moved_neighbours(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Bricks that are placed by one that is not there by then, or that may be elsewhere."""
    if not any(brick.written.placed_by for brick in built.bricks):
        return
    hit = _hit(built, scenario)
    for brick in built.bricks:
        for number in brick.written.placed_by:
            other = built.bricks[number]
            if (why := _why_unknown(other, brick.placed, hit)) is not None:
                message = f"brick '{brick.name}' is placed by '{other.name}' at {brick.placed.time:g} s, {why}"
                hint = "place it by another one, or `at` a place, or at another time"
                yield Diagnostic("SD204", _span(brick, source), message, hint)
                break


def _why_unknown(other: BuiltBrick, moment: ActionOrder, hit: Mapping[BodyId, ActionOrder]) -> str | None:
    """Why nobody knows where a brick is at a moment; None if it is where its author put it."""
    if other.written.drop:
        return "and where that one lies is known only to a run, as it is let go"
    if other.placed > moment:
        return f"and that one comes only at {other.placed.time:g} s"
    if other.gone is not None and other.gone <= moment:
        return f"and that one is pulled out at {other.gone.time:g} s"
    if other.name in hit and hit[other.name] <= moment:
        return f"and that one is hit at {hit[other.name].time:g} s, so that only a run knows where it is"
    return None


def _hit(built: Built, scenario: Scenario) -> Mapping[BodyId, ActionOrder]:
    """When each brick is first named by something that may move it."""
    found: dict[BodyId, ActionOrder] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        if impact.done.slid_in is None:
            for named in named_in(impact.done):
                found.setdefault(named.name, moment)
    return found


def _span(brick: BuiltBrick, source: Source) -> Span:
    key = "beside" if (*brick.written.path, "beside") in source.value_spans else "on"
    return source.span_of((*brick.written.path, key))


# Pieces of bricks, as at the ends of a wall, that are so small that statics cannot tell them from nothing.


def slivers(built: Built, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """One of each layout that has any; of a brick that is laid whole, its own keys tell it."""
    told: set[KeyPath] = set()
    for brick in built.bricks:
        made = brick.written
        if (made.shape.least_thickness < SHORTEST or made.mass < LIGHTEST) and made.path not in told:
            told.add(made.path)
            message = (
                f"brick '{brick.name}' is cut to {made.mass:.3g} kg and a side of {made.shape.least_thickness:.3g} m"
            )
            hint = f"give the layout measures that leave of every brick at least {LIGHTEST:g} kg and {SHORTEST:g} m"
            yield Diagnostic("SD104", source.span_of(made.path), message, hint)
