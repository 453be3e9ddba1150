"""Who rubs how on whom: what a scenario says of kinds, bricks and pairs -> the law that everybody asks."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from stability.friction_law import Friction, GivenFriction, Rule
from stability.model import BodyId
from stackdsl.compiling.built import Built
from stackdsl.diagnostics import Diagnostic, Span, did_you_mean
from stackdsl.language.bricks import BrickKind
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.pair_frictions import PairOfBodies
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def friction_of(built: Built, scenario: Scenario) -> GivenFriction:
    """One coefficient where nothing else is said, and else the whole law."""
    kinds = _kinds(built, scenario)
    # Of its kind, unless a brick is called as that.
    own = {
        name if kind.called in kinds or not kind.called else kind.called: kind.friction
        for name, kind in kinds.items()
        if kind.friction is not None
    }
    own |= {brick.name: brick.written.friction for brick in built.bricks if brick.written.friction is not None}
    between = {pair.pair: pair.friction for pair in scenario.world.friction.between}
    if not own and not between:
        return scenario.friction
    named = {*own, *(name for pair in between for name in pair)}
    called = {name: kind.called for name, kind in kinds.items() if kind.called in named}
    return Friction(scenario.friction, own, between, called, Rule(scenario.world.friction.rule))


def _kinds(built: Built, scenario: Scenario) -> Mapping[BodyId, BrickKind]:
    """What each brick is, also those that impacts throw or drop."""
    flying = {
        brick.id: (missile.brick if (missile := scenario.impacts[number].done.missile) else None) or scenario.brick
        for number, brick in built.missiles.items()
    }
    return {brick.name: brick.written.kind for brick in built.bricks} | flying


def mispaired(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Pairs of what is not there, of what never meets, and pairs of which two things are said."""
    pairs = scenario.world.friction.between
    bricks = {brick.name for brick in built.bricks} | {brick.id for brick in built.missiles.values()}
    planes, kinds = {plane.id for plane in built.planes}, {*scenario.brick_types, *CATALOGUE}
    for number, each in enumerate(pairs):
        span = source.span_of(("world", "friction", "between", number, "pair"))
        for place, name in enumerate(each.pair):
            there = source.span_of(("world", "friction", "between", number, "pair", place))
            if name not in bricks | planes | kinds:
                hint = did_you_mean(name, (*kinds, *sorted(planes), *sorted(bricks)))
                hint = hint or "name a kind of brick, a brick, the ground or a wall"
                yield Diagnostic("SD204", there, f"there is no brick '{name}', nor a kind of that name", hint)
            elif name in kinds and name in bricks | planes:
                message = f"'{name}' is a body and a kind of brick"
                yield Diagnostic("SD203", there, message, "call one of them otherwise")
        one, other = each.pair
        if one == other and one in bricks:
            yield Diagnostic(
                "SD104", span, f"'{one}' is one brick, and rubs on no other of its name", "name two bodies"
            )
        elif {one, other} <= planes:
            yield Diagnostic("SD104", span, "what never moves does not rub on its like", "name a brick, or a kind")
    yield from _said_twice(pairs, source)
    yield from _crossing(built, scenario, source, bricks)


def _said_twice(pairs: Sequence[PairOfBodies], source: Source) -> Iterator[Diagnostic]:
    first: dict[frozenset[str], int] = {}
    for number, each in enumerate(pairs):
        earlier = first.setdefault(frozenset(each.pair), number)
        if pairs[earlier].friction != each.friction:
            here, there = _lines(source, number, earlier)
            message = f"of this pair {pairs[earlier].friction:g} is said already, at {there}"
            yield Diagnostic("SD104", here, message, "keep one of them")


def _lines(source: Source, number: int, earlier: int) -> tuple[Span, str]:
    """Where one pair is said, and where another is, as seen from there."""
    here = source.span_of(("world", "friction", "between", number))
    return here, source.span_of(("world", "friction", "between", earlier)).seen_from(here)


def _crossing(built: Built, scenario: Scenario, source: Source, bricks: set[BodyId]) -> Iterator[Diagnostic]:
    """Two pairs, each of one brick and the kind of the other's, which say two things of the same two bricks."""
    pairs = scenario.world.friction.between
    called = {name: kind.called for name, kind in _kinds(built, scenario).items()}
    mixed = [
        (number, brick, kind)
        for number, each in enumerate(pairs)
        for brick, kind in (each.pair, each.pair[::-1])
        if brick in bricks and kind not in bricks
    ]
    told = {frozenset(each.pair) for each in pairs}
    for (first, a, kind_of_b), (second, b, kind_of_a) in combinations(mixed, 2):
        if a == b or called.get(a) != kind_of_a or called.get(b) != kind_of_b or frozenset((a, b)) in told:
            continue
        if pairs[first].friction != pairs[second].friction:
            here, there = _lines(source, second, first)
            message = f"{a} and {b} are a pair of this line and of that at {there}, which say different things"
            yield Diagnostic("SD104", here, message, f"say what [{a}, {b}] have")
