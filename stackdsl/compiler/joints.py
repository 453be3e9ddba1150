"""Joints of a scenario: the bodies that they join over time, and mistakes in them."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

from stability.geometry.box import box_of
from stability.joints import Bond, Joint, JointRule, Joints, Pull, Studs, on_one_grid
from stability.model import GROUND, BodyId
from stability.problem import Placed
from stackdsl.compiler.bricks import BEFORE_BUILDING, ActionOrder
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.bricks import CATALOGUE, side_off_studs
from stackdsl.language.impacts import Cut, Glue, Move
from stackdsl.language.joints import JoinedBodies, JointKind, Mortar, MortarOrGlue, StudGrid
from stackdsl.language.layouts.registry import MortaredParams
from stackdsl.language.model_base import Timed
from stackdsl.language.quantities import DURATION
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import JointChange, JointsAction
from stackdsl.trace import is_load
from stackdsl.wording import mm, time_text

SYSTEM: Final = "exact"  # the only system that plays joints
NOT_PLAYED: Final = "not everything is played with joints"
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
    sets: KeyPath | None = None  # the place of the time that it needs to set; None if it holds at once

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


def setting_at(time: float, built: ResolvedScenario, scenario: Scenario) -> Iterator[KeyPath]:
    """Yield the places of the times of all mortar and glue that sets at a time [s]."""
    placed = {brick.name: brick.placed.time for brick in built.bricks}
    for rule in _timed_rules(built, scenario):
        if rule.sets is not None and time in rule.times(placed):
            yield rule.sets


def _timed_rules(built: ResolvedScenario, scenario: Scenario) -> list[_TimedRule]:
    """Return the rules of a scenario, the first of which about two bodies counts as soon as it holds."""
    named = _named(built, scenario)
    smooth = frozenset(brick.name for brick in built.bricks if brick.written.kind.smooth)

    def acted(number: int, item: Glue | Cut) -> _TimedRule:
        begins = built.impacts[number].time
        there = {plane.id for plane in built.planes} | {b.name for b in built.bricks if b.placed.time <= begins}
        one, other = (each & there for each in _between(item, named))
        joint, setting = (_joint(item, smooth), _setting(item.bond)) if isinstance(item, Glue) else (None, None)
        path = ("impacts", number, scenario.impacts[number].kind, "bond", "from")
        return _TimedRule(joint, (one, other), begins + (setting or 0.0), sets=path if setting is not None else None)

    rules = [acted(*each) for each in _of_impacts(scenario)]
    rules.sort(key=lambda rule: rule.begins)
    rules.reverse()
    for number, item in enumerate(scenario.joints):
        setting, path = _setting(item.bond), ("joints", number, "bond", "from")
        timed = _TimedRule(
            _joint(item, smooth), _between(item, named), -inf, setting, path if setting is not None else None
        )
        rules.append(timed)
    for number, mortar in mortars_of(scenario):
        if mortar.bond is not None:
            laid = frozenset(brick.name for brick in built.bricks if brick.written.step == number)
            there = {plane.id for plane in built.planes}
            there.update(brick.name for brick in built.bricks if brick.written.step <= number)
            layout, setting = scenario.build[number].layout, _setting(mortar.bond)
            assert layout is not None
            place: KeyPath = ("build", number, layout[0], "mortar", "bond", "from")
            sides = laid, frozenset(there)
            rules.append(_TimedRule(_bond(mortar.bond), sides, -inf, setting, place if setting is not None else None))
    rules += _of_studs(built, scenario, smooth)
    return rules


def _named(built: ResolvedScenario, scenario: Scenario) -> Mapping[str, frozenset[BodyId]]:
    """Return the bodies of each name, and those of all names under an empty one; none for unknown names."""
    named = defaultdict(frozenset[BodyId], bodies_by_name(built, scenario))
    named[""] = frozenset(name for bodies in named.values() for name in bodies)
    return named


def _between(item: JoinedBodies, named: Mapping[str, frozenset[BodyId]]) -> tuple[frozenset[BodyId], frozenset[BodyId]]:
    """Return the two sets of bodies between which an item acts."""
    if item.between is not None:
        return named[item.between[0]], named[item.between[1]]
    together = frozenset[BodyId]().union(*(named[name] for name in item.of or ("",)))
    return together, together


def _of_studs(built: ResolvedScenario, scenario: Scenario, smooth: frozenset[BodyId]) -> Iterator[_TimedRule]:
    """Yield a rule for each kind of studs, between all bodies that have them."""
    bodies: defaultdict[StudGrid, set[BodyId]] = defaultdict(set)
    for brick in built.bricks:
        if brick.written.kind.studs is not None:
            bodies[brick.written.kind.studs].add(brick.name)
    for studs, names in bodies.items():
        together = frozenset(names | ({GROUND} if scenario.world.ground.studs == studs else set()))
        yield _TimedRule(_studs(studs, smooth), (together, together))


def _studs(grid: StudGrid, smooth: frozenset[BodyId]) -> Studs:
    return Studs(grid.pitch, grid.pull, grid.shear, grid.narrow_pull, smooth=smooth, ductile=grid.ductile)


def _setting(bond: MortarOrGlue | None) -> float | None:
    return None if bond is None else bond.from_


def _bond(bond: MortarOrGlue) -> Bond:
    return Bond(
        bond.tension, bond.cohesion, inf if bond.shear is None else bond.shear, bond.brittle, ductile=bond.ductile
    )


def _joint(item: JointKind, smooth: frozenset[BodyId]) -> Joint | None:
    if item.bond is not None:
        return _bond(item.bond)
    if item.pull is not None:
        return Pull(item.pull.force, ductile=item.pull.ductile)
    if item.studs is not None:
        return _studs(item.studs, smooth)
    return None


def bodies_by_name(built: ResolvedScenario, scenario: Scenario) -> Mapping[str, frozenset[BodyId]]:
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
    """Report wrong names in joints, and actions and claims that joined bricks do not support."""
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
    bodies = bodies_by_name(built, scenario)
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
        key = "of" if item.between is None else "between"
        for place, name in enumerate(item.named):
            span = source.span_of((*path, key, place))
            meant = [meaning for known, meaning in meanings if name in known]
            if name not in bodies:
                hint = did_you_mean(name, sorted(bodies)) or "write the name of a kind, a step, a brick or a plane"
                yield Diagnostic("SD204", span, f"there is no kind of brick, step or brick '{name}'", hint)
            elif len(meant) > 1:
                yield Diagnostic(
                    "SD203", span, f"'{name}' is the name of {' and of '.join(meant)}", "rename one of them"
                )
        named = {name for name in item.named if name in bodies}
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
    named = _named(built, scenario)
    for number, mortar in mortars_of(scenario):
        laid = {brick.name for brick in built.bricks if brick.written.step == number}
        if mortar.bond is None and not any(
            laid & named[name] for item in scenario.joints for name in item.named or ("",)
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


def _refused(source: Source, path: KeyPath, refusal: str, key: str) -> Diagnostic:
    return Diagnostic("SD211", source.key_span_of(path), f"{NOT_PLAYED}: {refusal}", f"remove {key}, or {_dry(source)}")


def _dry(source: Source) -> str:
    """Return the remedy that makes the bricks of a scenario dry."""
    return "remove `joints`" if "joints" in source.values else "use bricks without studs"


def _unjudged(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, actions and margins that joined bricks do not have."""
    for system in (system for system in scenario.systems if system != SYSTEM):
        yield _refused(source, ("systems",), f"the system '{system}' plays no joints", "it")
    yield from _unplayed_actions(scenario, source)
    yield from _unjudged_claims(scenario, source)


def _unplayed_actions(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for number, impact in enumerate(scenario.impacts):
        if isinstance(impact.content, Move) and impact.content.slid:
            path: KeyPath = ("impacts", number, "move", "slid")
            yield _refused(source, path, "a brick with joints is not slid", "`slid`, so that the brick is carried")


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
            elif others := sorted(margin for margin in needed - MARGINS if not is_load(margin)):
                message = f"the margin `{others[0]}` is not computed for bricks with joints"
                yield Diagnostic(
                    "SD211",
                    span,
                    message,
                    f"claim the margin `load_factor`, `acceleration` or `tilt`, or {_dry(source)}",
                )


# Joints that act at no contact.


@dataclass(frozen=True, slots=True)
class Meeting:
    """Two bodies that touch when the later one is set down."""

    names: tuple[BodyId, BodyId]
    one: Placed
    other: Placed | None  # None for a plane
    since: float  # [s] from which both are in place
    until: float  # [s] of the first removal

    def has_studs(self, pitch: float) -> bool:
        """Return whether both bodies are boxes of whole studs on one grid; a plane has studs everywhere."""
        boxes = [box_of(placed.brick.shape) for placed in (self.one, self.other) if placed is not None]
        fit = all(box is not None and side_off_studs(box[0].size, pitch) is None for box in boxes)
        return fit and (self.other is None or on_one_grid(self.one, self.other, pitch))


MOST_COMPARED: Final = 1_000_000  # items times contacts that are searched for idle joints; takes a second


def idle_joints(
    meetings: Sequence[Meeting], built: ResolvedScenario, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    """Report items of `joints`, glue and cuts that act at no contact.

    An item about kinds or steps that never touch is no mistake: in another case of the scenario they may.
    """
    named, acted = _named(built, scenario), list(_of_impacts(scenario))
    if (len(scenario.joints) + len(acted)) * len(meetings) > MOST_COMPARED:
        return
    planes = {plane.id for plane in built.planes}
    single = planes | {brick.name for brick in built.bricks}
    earlier: list[JointRule] = []
    for number, item in enumerate(scenario.joints):
        rule = JointRule(None, _between(item, named))
        held = [each for each in meetings if rule.holds(*each.names)]
        path: KeyPath = ("joints", number)
        if not held and single.issuperset(item.named) and not planes.issuperset(item.named):
            message = "no two of these bodies touch when they are set down, so no joint acts between them"
            yield Diagnostic("SD104", source.span_of(path), message, "name bodies that touch, or remove the item")
        elif held and all(any(before.holds(*each.names) for before in earlier) for each in held):
            message = "earlier items are about all contacts of these bodies, so this item never counts"
            yield Diagnostic("SD104", source.span_of(path), message, "move it before them, or remove it")
        yield from _off_grid(item, held, path, source)
        if _setting(item.bond) is None:
            earlier.append(rule)
    rules, placed = _timed_rules(built, scenario), {brick.name: brick.placed.time for brick in built.bricks}
    for number, impact in acted:
        time, path = built.impacts[number].time, ("impacts", number, scenario.impacts[number].kind)
        rule = JointRule(None, _between(impact, named))
        held = [each for each in meetings if each.since <= time < each.until and rule.holds(*each.names)]
        span = source.key_span_of(path)
        if isinstance(impact, Glue):
            if not held:
                message = f"no two of these bodies are in place and touch at {time_text(time)}"
                yield Diagnostic("SD104", span, message, "name bodies that touch, and glue them after they are placed")
            yield from _off_grid(impact, held, path, source)
            continue
        joints = Joints(tuple(rule.at(time, placed) for rule in rules if rule.begins < time))
        if all(joints.of(*each.names) is None for each in held):
            message = f"no joint holds these bodies together at {time_text(time)}"
            yield Diagnostic("SD104", span, message, "name bodies that a joint holds at this time, or remove the cut")


def _off_grid(item: JointKind, held: Sequence[Meeting], path: KeyPath, source: Source) -> Iterator[Diagnostic]:
    """Report studs of an item that hold no two of its bodies that touch."""
    studs = item.studs
    if studs is not None and held and not any(each.has_studs(studs.pitch) for each in held):
        message = f"no two of these bodies are boxes on one grid of {mm(studs.pitch)}, so no stud holds"
        hint = "write the `pitch` of which their sides are multiples, and place them on its grid"
        yield Diagnostic("SD104", source.key_span_of((*path, "studs")), message, hint)
