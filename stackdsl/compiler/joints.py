"""Joints of a scenario: their bodies by name, and refusals of all that is not played for joined bricks."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Final

from stability.joints import Bond, Joint, JointRule, Joints, Pull, Studs
from stability.model import GROUND, BodyId
from stackdsl.compiler.bricks import BEFORE_BUILDING, ActionOrder
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.bricks import CATALOGUE
from stackdsl.language.impacts import Cut, Glue
from stackdsl.language.joints import JoinedBodies, JointKind, Mortar, MortarOrGlue, StudGrid
from stackdsl.language.layouts.registry import MortaredParams
from stackdsl.language.model_base import Timed
from stackdsl.language.quantities import DURATION
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import JointChange, JointsAction
from stackdsl.wording import mm

SYSTEM: Final = "exact"  # the only system that plays joints
NOT_PLAYED: Final = "not everything is played with joints"
# All others are those of hands.
IMPACTS: Final = frozenset({"remove", "insert", "throw", "push", "drop", "glue", "cut"})
MARGINS: Final = frozenset({"load_factor", "acceleration", "tilt"})


MOST_CHANGES: Final = 2000  # of the joints in time; each change judges the structure again


def mortars_of(scenario: Scenario) -> Iterator[tuple[int, Mortar]]:
    """Yield the mortar of each layout that has some, with the number of its step."""
    for number, step in enumerate(scenario.build):
        params = step.layout[1] if step.layout is not None else None
        if isinstance(params, MortaredParams) and params.mortar is not None:
            yield number, params.mortar


def _of_impacts(scenario: Scenario) -> Iterator[tuple[int, Glue | Cut]]:
    for number, impact in enumerate(scenario.impacts):
        if isinstance(impact.content, Glue | Cut):
            yield number, impact.content


# Joints in time. The joints of a moment are rules, of which the first one about two bodies counts: the last action
# first, then the items of `joints`, then the mortar of layouts. A joint that has not set yet does not count.


@dataclass(frozen=True, slots=True)
class _TimedRule:
    """Joint between bodies of two sets, which holds from some time on."""

    joint: Joint | None
    between: tuple[frozenset[BodyId], frozenset[BodyId]]
    begins: float = -inf  # [s]
    after_placing: float | None = None  # [s] after both bodies are placed; None if it holds at once

    def times(self, placed: Mapping[BodyId, float]) -> Iterator[float]:
        """Yield the times at which it begins to hold for some bodies [s]."""
        if self.begins > -inf:
            yield self.begins
        if self.after_placing is not None:
            yield from (placed[name] + self.after_placing for each in self.between for name in each if name in placed)

    def at(self, time: float, placed: Mapping[BodyId, float]) -> JointRule:
        """Return the rule at a time [s]; without bodies if it does not hold yet."""
        delay = self.after_placing
        if time < self.begins:
            return JointRule(self.joint, (frozenset(), frozenset()))
        if delay is None:
            return JointRule(self.joint, self.between)
        one, other = (
            frozenset(name for name in each if placed.get(name, -inf) + delay <= time) for each in self.between
        )
        return JointRule(self.joint, (one, other))


def joints_in_time(
    built: ResolvedScenario, scenario: Scenario
) -> tuple[Joints, Sequence[tuple[ActionOrder, JointsAction]]]:
    """Return the joints at the start, and the changes of joints in order of time."""
    rules, placed = _timed_rules(built, scenario), {brick.name: brick.placed.time for brick in built.bricks}
    now = first = Joints(tuple(rule.at(-inf, placed) for rule in rules))
    changes = []
    acted = {built.impacts[number].time: (built.impacts[number], impact) for number, impact in _of_impacts(scenario)}
    for time in sorted({time for rule in rules for time in rule.times(placed)}):
        before, now = now, Joints(tuple(rule.at(time, placed) for rule in rules))
        if now == before:
            continue
        pairs = [each for each in zip(now.rules, before.rules, strict=True) if each[0] != each[1]]
        bodies = {
            name
            for rule, old in pairs
            for each, less in zip(rule.between, old.between, strict=True)
            for name in each
            if name not in less
        }
        bricks = tuple(each.name for each in built.in_order if each.name in bodies and each.placed.time <= time)
        # Mortar that sets holds bricks that are placed at the same time; bricks are placed before they are glued.
        order, change = ActionOrder(time, BEFORE_BUILDING), JointChange.SET
        if time in acted:
            order, impact = acted[time]
            change = JointChange.CUT if isinstance(impact, Cut) else JointChange.JOINED
        if bricks:
            changes.append((order, JointsAction(time, now, bricks, change)))
    return first, changes


def _timed_rules(built: ResolvedScenario, scenario: Scenario) -> list[_TimedRule]:
    """Return the rules of a scenario, the first of which about two bodies counts as soon as it holds."""
    named = defaultdict(frozenset[BodyId], _bodies(built, scenario))  # unknown names are reported by `_names`
    everything = frozenset(name for bodies in named.values() for name in bodies)

    def between(item: JoinedBodies) -> tuple[frozenset[BodyId], frozenset[BodyId]]:
        if item.between is not None:
            one, other = item.between
            return named[one], named[other]
        together = everything if item.of is None else frozenset[BodyId]().union(*(named[name] for name in item.of))
        return together, together

    def acted(number: int, item: Glue | Cut) -> _TimedRule:
        begins = built.impacts[number].time
        there = {plane.id for plane in built.planes} | {b.name for b in built.bricks if b.placed.time <= begins}
        one, other = between(item)
        joint, setting = (_joint(item), _setting(item.bond)) if isinstance(item, Glue) else (None, None)
        return _TimedRule(joint, (one & there, other & there), begins + (setting or 0.0))

    rules = [acted(*each) for each in _of_impacts(scenario)]
    rules.sort(key=lambda rule: rule.begins)
    rules.reverse()
    for item in scenario.joints:
        rules.append(_TimedRule(_joint(item), between(item), after_placing=_setting(item.bond)))
    for number, mortar in mortars_of(scenario):
        if mortar.bond is not None:
            laid = frozenset(brick.name for brick in built.bricks if brick.written.step == number)
            there = {plane.id for plane in built.planes}
            there.update(brick.name for brick in built.bricks if brick.written.step <= number)
            sets = laid, frozenset(there)
            rules.append(_TimedRule(_bond(mortar.bond), sets, after_placing=_setting(mortar.bond)))
    rules += _of_studs(built, scenario)
    return rules


def _of_studs(built: ResolvedScenario, scenario: Scenario) -> Iterator[_TimedRule]:
    """Yield a rule for each kind of studs, between all bodies that have them."""
    bodies: defaultdict[StudGrid, set[BodyId]] = defaultdict(set)
    for brick in built.bricks:
        if brick.written.kind.studs is not None:
            bodies[brick.written.kind.studs].add(brick.name)
    smooth = frozenset(brick.name for brick in built.bricks if brick.written.kind.smooth)
    for studs, names in bodies.items():
        together = frozenset(names | ({GROUND} if scenario.world.ground.studs == studs else set()))
        yield _TimedRule(replace(_studs(studs), smooth=smooth & together), (together, together))


def _studs(grid: StudGrid) -> Studs:
    return Studs(grid.pitch, grid.pull, grid.shear, grid.narrow_pull)


def _setting(bond: MortarOrGlue | None) -> float | None:
    return None if bond is None else bond.from_


def _bond(bond: MortarOrGlue) -> Bond:
    return Bond(bond.tension, bond.cohesion, inf if bond.shear is None else bond.shear, bond.brittle)


def _joint(item: JointKind) -> Joint | None:
    if item.bond is not None:
        return _bond(item.bond)
    if item.pull is not None:
        return Pull(item.pull)
    if item.studs is not None:
        return _studs(item.studs)
    return None


def _bodies(built: ResolvedScenario, scenario: Scenario) -> Mapping[str, frozenset[BodyId]]:
    """Return the bodies that each name stands for: a brick or a plane, the bricks of a kind, or those of a step."""
    bodies: defaultdict[str, set[BodyId]] = defaultdict(set)
    for kind in (*CATALOGUE, *scenario.brick_types):
        bodies[kind] = set()
    for plane in built.planes:
        bodies[plane.id].add(plane.id)
    for brick in built.bricks:
        step = None if brick.written.inserted else scenario.build[brick.written.step].name
        for name in {brick.name, brick.written.kind.kind_name, step} - {None, ""}:
            bodies[str(name)].add(brick.name)
    return {name: frozenset(each) for name, each in bodies.items()}


def are_joined(built: ResolvedScenario, scenario: Scenario) -> bool:
    """Return whether joints may hold bricks together."""
    if scenario.joints or any(mortars_of(scenario)) or any(_of_impacts(scenario)):
        return True
    return any(brick.written.kind.studs is not None for brick in built.bricks)


def invalid_joints(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report unknown and ambiguous names of joints, and all that is not played or computed for joined bricks."""
    studs = scenario.world.ground.studs
    if studs is not None and all(brick.written.kind.studs != studs for brick in built.bricks):
        span = source.key_span_of(("world", "ground", "studs"))
        hint = "use bricks such as `lego_2x4`, or remove `studs` of the ground"
        yield Diagnostic("SD104", span, "no brick has the studs of the ground", hint)
    if not are_joined(built, scenario):
        yield from _long_times(scenario, source)
        return
    yield from _names(built, scenario, source)
    yield from _weak_mortar(built, scenario, source)
    yield from _too_many_changes(built, scenario, source)
    yield from _unjudged(scenario, source)


def _names(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    bodies = _bodies(built, scenario)
    planes = {plane.id for plane in built.planes}
    meanings = (
        ({*CATALOGUE, *scenario.brick_types}, "a kind of brick"),
        ({step.name for step in scenario.build if step.name is not None}, "a step"),
        ({brick.name for brick in built.bricks}, "a brick"),
    )
    items: list[tuple[KeyPath, JoinedBodies]] = [
        (("joints", index), item) for index, item in enumerate(scenario.joints)
    ]
    items += [(("impacts", number, scenario.impacts[number].kind), item) for number, item in _of_impacts(scenario)]
    for path, item in items:
        key, names = ("between", item.between) if item.between is not None else ("of", item.of or ())
        for place, name in enumerate(names):
            span = source.span_of((*path, key, place))
            meant = [meaning for known, meaning in meanings if name in known]
            if name not in bodies:
                hint = did_you_mean(name, sorted(bodies)) or "write the name of a kind, a step, a brick or a plane"
                yield Diagnostic("SD204", span, f"there is no kind of brick, step or brick '{name}'", hint)
            elif len(meant) > 1:
                yield Diagnostic(
                    "SD203", span, f"'{name}' is the name of {' and of '.join(meant)}", "rename one of them"
                )
        named = {name for name in names if name in bodies}
        if named and named <= planes:
            message = "these bodies are fixed, so no joint acts between them"
            yield Diagnostic("SD104", source.span_of((*path, key)), message, "name at least one brick or kind of brick")


def _long_times(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report times of more than a day, for which only structures that are judged at rest are not simulated."""
    steps: list[tuple[KeyPath, Timed, float | None]] = [
        (("build", number), step, step.every) for number, step in enumerate(scenario.build)
    ]
    steps += [(("impacts", number), impact, impact.every) for number, impact in enumerate(scenario.impacts)]
    for path, step, every in steps:
        offset = None if step.after is None else step.after.offset
        for key, time in (("at", step.at), ("after", offset), ("every", every)):
            if time is not None and time > DURATION.most:
                message = f"the time of {time / DURATION.most:g} days is too long"
                hint = "write at most 1 d; only structures with `joints` may stand for longer"
                yield Diagnostic("SD104", source.span_of((*path, key)), message, hint)


def _weak_mortar(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report mortar without a strength, unless an item of `joints` names bricks of its layout."""
    named = _bodies(built, scenario)
    for number, mortar in mortars_of(scenario):
        laid = {brick.name for brick in built.bricks if brick.written.step == number}
        names = [each.of if each.between is None else each.between for each in scenario.joints]
        if mortar.bond is None and not any(
            each is None or any(laid & named.get(name, frozenset()) for name in each) for each in names
        ):
            layout = scenario.build[number].layout
            assert layout is not None
            span = source.key_span_of(("build", number, layout[0], "mortar"))
            thickness = mm(mortar.thickness)
            hint = (
                f"write `mortar: {{thickness: {thickness}, bond: {{tension: 0.2 MPa, cohesion: 0.3 MPa}}}}`, "
                "or add its joint to `joints`"
            )
            yield Diagnostic("SD102", span, "the mortar has no strength", hint)


def _too_many_changes(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    if built.timing_mistakes:
        return
    rules, placed = _timed_rules(built, scenario), {brick.name: brick.placed.time for brick in built.bricks}
    changes = len({time for rule in rules for time in rule.times(placed)})
    if changes > MOST_CHANGES:
        message = f"the joints set at {changes} different times; the maximum is {MOST_CHANGES}"
        yield Diagnostic("SD206", source.key_span_of(("build",)), message, "place several bricks at the same time")


def _refused(source: Source, path: KeyPath, what: str, key: str) -> Diagnostic:
    return Diagnostic("SD211", source.key_span_of(path), f"{NOT_PLAYED}: {what}", f"remove {key}, or {_dry(source)}")


def _dry(source: Source) -> str:
    """Return how the bricks of a scenario become dry."""
    return "remove `joints`" if "joints" in source.values else "use bricks without studs"


def _unjudged(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, actions and margins that joined bricks do not have."""
    for system in (system for system in scenario.systems if system != SYSTEM):
        yield _refused(source, ("systems",), f"the system '{system}' plays no joints", "it")
    yield from _unplayed_actions(scenario, source)
    yield from _unjudged_claims(scenario, source)


def _unplayed_actions(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for number, step in enumerate(scenario.build):
        if step.place is not None:
            yield _refused(source, ("build", number, "place"), "hands are not played", "`place`")
    for number, impact in enumerate(scenario.impacts):
        if impact.kind not in IMPACTS:
            yield _refused(source, ("impacts", number, impact.kind), f"the impact `{impact.kind}` is not played", "it")


def _unjudged_claims(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    bonds = [item.bond for item in scenario.joints] + [mortar.bond for _, mortar in mortars_of(scenario)]
    bonds += [item.bond for _, item in _of_impacts(scenario) if isinstance(item, Glue)]
    brittle = any(bond is not None and bond.brittle for bond in bonds)
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            span = source.key_span_of((key, number, claim.kind))
            needed = {*claim.content.needed_margins}
            if brittle and (others := sorted(needed & {"acceleration", "tilt"})):
                message = f"the margin `{others[0]}` is not computed for brittle joints"
                hint = "claim the margin `load_factor`, or remove `brittle`"
                yield Diagnostic("SD211", span, message, hint)
            elif others := sorted(needed - MARGINS):
                message = f"the margin `{others[0]}` is not computed for bricks with joints"
                yield Diagnostic(
                    "SD211",
                    span,
                    message,
                    f"claim the margin `load_factor`, `acceleration` or `tilt`, or {_dry(source)}",
                )
