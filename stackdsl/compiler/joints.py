"""Joints of a scenario: their bodies by name, and refusals of all that is not judged for joined bricks."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Final

from stability.joints import Bond, Joint, JointRule, Joints, Pull, Studs
from stability.model import GROUND, BodyId
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.bricks import CATALOGUE
from stackdsl.language.joints import JointOfBricks, StudGrid
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source

SYSTEM: Final = "exact"  # the only system that judges joints
AT_REST: Final = "joints are judged at rest only"
IMPACTS: Final = frozenset({"remove", "insert"})  # that statics judge
CLAIMS: Final = frozenset({"stands", "collapses", "verdict", "margin", "rests_on"})  # that need no motion
MARGINS: Final = frozenset({"load_factor", "acceleration", "tilt"})


def joints_of(built: ResolvedScenario, scenario: Scenario) -> Joints:
    """Return the joints of a scenario."""
    named = _bodies(built, scenario)
    everything = frozenset(name for bodies in named.values() for name in bodies)

    def rules(item: JointOfBricks) -> Iterator[JointRule]:
        joint = _joint(item)
        if item.between is not None:
            one, other = item.between
            yield JointRule(joint, (named[one], named[other]))
            return
        sets = [everything] if item.of is None else [named[name] for name in item.of]
        together = frozenset[BodyId]().union(*sets)
        yield JointRule(joint, (together, together))

    written = (rule for item in scenario.joints for rule in rules(item))
    return Joints((*written, *_of_studs(built, scenario)))


def _of_studs(built: ResolvedScenario, scenario: Scenario) -> Iterator[JointRule]:
    """Yield a rule for each kind of studs, between all bodies that have them."""
    bodies: defaultdict[StudGrid, set[BodyId]] = defaultdict(set)
    for brick in built.bricks:
        if brick.written.kind.studs is not None:
            bodies[brick.written.kind.studs].add(brick.name)
    for studs, names in bodies.items():
        together = frozenset(names | ({GROUND} if scenario.world.ground.studs == studs else set()))
        yield JointRule(_studs(studs), (together, together))


def _studs(grid: StudGrid) -> Studs:
    return Studs(grid.pitch, grid.pull, grid.shear, grid.narrow_pull)


def _joint(item: JointOfBricks) -> Joint | None:
    if item.bond is not None:
        bond = item.bond
        return (
            Bond(bond.tension, bond.cohesion) if bond.shear is None else Bond(bond.tension, bond.cohesion, bond.shear)
        )
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
    return bool(scenario.joints) or any(brick.written.kind.studs is not None for brick in built.bricks)


def invalid_joints(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report unknown and ambiguous names of joints, and all that is not judged for joined bricks."""
    studs = scenario.world.ground.studs
    if studs is not None and all(brick.written.kind.studs != studs for brick in built.bricks):
        span = source.key_span_of(("world", "ground", "studs"))
        hint = "use bricks such as `lego_2x4`, or remove `studs` of the ground"
        yield Diagnostic("SD104", span, "no brick has the studs of the ground", hint)
    if not are_joined(built, scenario):
        return
    yield from _names(built, scenario, source)
    yield from _unjudged(scenario, source)


def _names(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    bodies = _bodies(built, scenario)
    planes = {plane.id for plane in built.planes}
    meanings = (
        ({*CATALOGUE, *scenario.brick_types}, "a kind of brick"),
        ({step.name for step in scenario.build if step.name is not None}, "a step"),
        ({brick.name for brick in built.bricks}, "a brick"),
    )
    for number, item in enumerate(scenario.joints):
        key, names = ("between", item.between) if item.between is not None else ("of", item.of or ())
        for place, name in enumerate(names):
            span = source.span_of(("joints", number, key, place))
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
            yield Diagnostic(
                "SD104", source.span_of(("joints", number, key)), message, "name at least one brick or kind of brick"
            )


def _refused(source: Source, path: KeyPath, what: str, key: str) -> Diagnostic:
    return Diagnostic("SD211", source.key_span_of(path), f"{AT_REST}: {what}", f"remove {key}, or {_dry(source)}")


def _dry(source: Source) -> str:
    """Return how the bricks of a scenario become dry."""
    return "remove `joints`" if "joints" in source.values else "use bricks without studs"


def _unjudged(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, actions and claims that joined bricks do not have."""
    for system in (system for system in scenario.systems if system != SYSTEM):
        yield _refused(source, ("systems",), f"the system '{system}' plays no joints", "it")
    if scenario.samples is not None:
        yield _refused(source, ("samples",), "samples are not judged", "`samples`")
    if scenario.world.shake is not None:
        yield _refused(source, ("world", "shake"), "shaking is not played", "`shake`")
    yield from _unplayed_actions(scenario, source)
    yield from _unjudged_claims(scenario, source)


def _unplayed_actions(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for number, step in enumerate(scenario.build):
        if step.place is not None:
            yield _refused(source, ("build", number, "place"), "hands are not played", "`place`")
        for index, brick in enumerate(step.bricks or ()):
            if brick.drop:
                path = ("build", number, "bricks", index, "drop")
                yield _refused(source, path, "drops are not played", "`drop`")
    for number, impact in enumerate(scenario.impacts):
        if impact.kind not in IMPACTS:
            yield _refused(source, ("impacts", number, impact.kind), f"the impact `{impact.kind}` is not played", "it")


def _unjudged_claims(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            span = source.key_span_of((key, number, claim.kind))
            if claim.kind not in CLAIMS:
                message = f"{AT_REST}, and the claim `{claim.kind}` is about a motion"
                hint = f"claim one of {', '.join(sorted(CLAIMS))}, or {_dry(source)}"
                yield Diagnostic("SD211", span, message, hint)
            elif others := sorted({*claim.content.needed_margins} - MARGINS):
                message = f"the margin `{others[0]}` is not computed for bricks with joints"
                yield Diagnostic(
                    "SD211",
                    span,
                    message,
                    f"claim the margin `load_factor`, `acceleration` or `tilt`, or {_dry(source)}",
                )
