"""Compiler, explanation, statics and stabilizer agree on whether a plank a little above another touches it."""

from dataclasses import replace

import pytest

from stability.geometry.box_distance import reach_between
from stability.model import Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.judging.proofs import finished_structure_of, proofs_of
from stackdsl.report.statics import Extent, explanation_text, statics_summary_of
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.simulation.worlds import extension_for, opened_world
from stackdsl.timeline import Placement
from tests.scenes import compiled, scene, timeline_of

KAPLA, TINY, HUGE = (117.6, 23.4, 7.8), (10.0, 2.0, 0.6), (1200.0, 240.0, 80.0)  # [mm]
# Of a KAPLA plank [mm], the limit itself among them; of others, the same shares on both sides of the limit.
ABOVE = [0.1, 0.15, 0.156, 0.2, 0.3, 0.45, 0.5, 0.6, 1.0]
NEAR = [0.15, 0.156, 0.2]
SCENES = [
    pytest.param(size, above / KAPLA[2] * size[2], turned, id=f"{size[0]:g}mm-{above / KAPLA[2]:.3f}-{turned}deg")
    for size, turned, heights in ((KAPLA, 0, NEAR), (KAPLA, 30, ABOVE), (TINY, 30, NEAR), (HUGE, 0, NEAR))
    for above in heights
]
EACH = pytest.mark.parametrize(("size", "above", "turned"), SCENES)


def text_of(size: tuple[float, float, float], above: float, turned: int) -> str:
    """A plank so far above another [mm], turned about the vertical [deg]."""
    length, width, height = size
    brick = f"brick: {{size: [{length} mm, {width} mm, {height} mm], density: 500 kg/m3}}"
    at = (0.5 * height, 1.5 * height + above)
    low, high = (f"at: [0 mm, 0 mm, {z!r} mm], {brick}" for z in at)
    return f"- bricks: [{{name: low, {low}}}, {{name: high, {high}, rotate: [0 deg, 0 deg, {turned} deg]}}]"


def placed(size: tuple[float, float, float], above: float, turned: int) -> list[Placement]:
    """The two as they are set down, compiled as if they touched and then raised."""
    low, high = timeline_of(text_of(size, 0.0, turned)).placements
    x, y, z = high.pose.position_W
    return [low, replace(high, pose=Pose((x, y, z + above / 1000.0), high.pose.orientation))]


def touches(size: tuple[float, float, float], above: float) -> bool:
    return above <= reach_between(size[2])


@EACH
def test_the_compiler_takes_it_for_set_down_or_in_the_air(
    size: tuple[float, float, float], above: float, turned: int
) -> None:
    _, mistakes = compiled(scene(text_of(size, above, turned)))
    assert [mistake.code for mistake in mistakes] == ([] if touches(size, above) else ["SD202"])


@EACH
def test_the_explanation_says_on_what_it_lies_and_that_this_holds_it(
    size: tuple[float, float, float], above: float, turned: int
) -> None:
    cases, mistakes = compiled(scene(text_of(size, above, turned)))
    if touches(size, above):
        told = next(line for line in explanation_text(cases, Extent(margins=False)).splitlines() if " high " in line)
        assert "on low  load core" in told
    else:
        assert "brick 'high' has no support" in mistakes[0].message


@EACH
def test_statics_prove_it_to_stand_or_to_fall(size: tuple[float, float, float], above: float, turned: int) -> None:
    assembly = Assembly(timeline_of(text_of(size, 0.0, turned)).world.planes)
    verdict = assembly.add_all(Placed(each.brick, each.pose) for each in placed(size, above, turned))
    assert verdict.stability is (Stability.STABLE if touches(size, above) else Stability.UNSTABLE)
    assert verdict.moving == (() if touches(size, above) else ("high",))


@pytest.mark.parametrize("system", ["exact", "thesis"])
@EACH
def test_the_extension_holds_it_or_leaves_it_to_the_engine(
    size: tuple[float, float, float], above: float, turned: int, system: str
) -> None:
    timeline = timeline_of(text_of(size, 0.0, turned))
    world = opened_world(timeline, SYSTEMS[system])
    extension = extension_for(timeline, SYSTEMS[system], world)
    assert extension is not None
    for each in placed(size, above, turned):
        world.add_brick(each.brick, each.pose)
        extension.set_down([each.brick.id])
        extension.update()
    assert extension.is_frozen("low")
    assert extension.is_frozen("high") is touches(size, above)
    assert extension.shares(["high"]) == ({"high": {"low": pytest.approx(1.0)}} if touches(size, above) else {})
    world.close()


@pytest.mark.parametrize("above", [0.15601, 0.1560001, 0.2, 0.5])
def test_how_far_it_is_away_is_never_told_as_what_it_may_be(above: float) -> None:
    (mistake,) = compiled(scene(text_of(KAPLA, above, 0)))[1]
    assert f"{above} mm away; the largest gap that counts as contact is 0.156" in mistake.message
    assert f"up to {above} mm" not in mistake.message


def bridge(size: tuple[float, float, float], lower: float) -> str:
    """A plank on one under its middle, and above another under its end that is so much lower [mm], being thinner."""
    length, width, height = size
    thin = f"brick: {{size: [{length} mm, {width} mm, {height - lower!r} mm], density: 500 kg/m3}}"
    usual = f"brick: {{size: [{length} mm, {width} mm, {height} mm], density: 500 kg/m3}}"
    return f"""
        - bricks:
            - {{name: amid, at: [0 mm, 0 mm, {height / 2} mm], rotate: [0 deg, 0 deg, 90 deg], {usual}}}
            - name: end
              at: [{0.4 * length} mm, 0 mm, {(height - lower) / 2!r} mm]
              rotate: [0 deg, 0 deg, 90 deg]
              {thin}
            - {{name: high, at: [0 mm, 0 mm, {1.5 * height} mm], {usual}}}
    """


@pytest.mark.parametrize("system", ["exact", "thesis"])
@pytest.mark.parametrize("above", ABOVE)
@pytest.mark.parametrize("size", [KAPLA, TINY, HUGE])
def test_all_name_the_same_bodies_that_a_plank_rests_on(
    size: tuple[float, float, float], above: float, system: str
) -> None:
    lower = above / KAPLA[2] * size[2]
    on = ["amid", "end"] if lower <= reach_between(size[2] - lower) else ["amid"]
    cases, mistakes = compiled(scene(bridge(size, lower)))
    assert mistakes == []
    told = next(line for line in explanation_text(cases, Extent(margins=False)).splitlines() if " high " in line)
    assert f"on {', '.join(on)}  " in told
    timeline = cases[0].timeline
    assembly = Assembly(timeline.world.planes)
    assembly.add_all(Placed(each.brick, each.pose) for each in timeline.placements)
    assert sorted(contact.lower for contact in assembly.contacts("high")) == on
    world = opened_world(timeline, SYSTEMS[system])
    extension = extension_for(timeline, SYSTEMS[system], world)
    assert extension is not None
    for each in timeline.placements:
        world.add_brick(each.brick, each.pose)
        extension.set_down([each.brick.id])
        extension.update()
    assert sorted(extension.shares(["high"])["high"]) == on
    world.close()


@pytest.mark.parametrize("size", [KAPLA, TINY, HUGE])
@pytest.mark.parametrize("deep", [0.001, 0.002, 0.01, 0.05, 0.1, 0.15, 0.3])  # [mm]
def test_an_overlap_that_the_compiler_forgives_is_a_contact_that_statics_prove(
    size: tuple[float, float, float], deep: float
) -> None:
    cases, mistakes = compiled(scene(text_of(size, -deep, 0)))
    assert [mistake.code for mistake in mistakes] == ([] if deep <= min(0.1, reach_between(size[2])) else ["SD201"])
    if cases:
        told = next(line for line in explanation_text(cases, Extent(margins=False)).splitlines() if " high " in line)
        assert "on low  load core" in told


@pytest.mark.parametrize(
    ("touching", "stands"),
    [("exactly", False), ("within 0.09 mm", False), ("within 0.1 mm", True), ("within 1 m", True)],
)
def test_a_gap_counts_for_everybody_as_the_world_says(touching: str, stands: bool) -> None:
    timeline = timeline_of(text_of(KAPLA, 0.1, 0), f"world: {{touching: {touching}}}")
    stability = Stability.STABLE if stands else Stability.UNSTABLE
    assert proofs_of(timeline).assembly.verdict().stability is stability
    assert finished_structure_of(timeline).assembly.verdict().stability is stability
    trace = play(timeline, SYSTEMS["exact"])
    assert trace.statics is not None
    assert trace.statics.stability is stability
    assert trace.statics.touching_within == (pytest.approx(1e-4) if stands else 0.0)
    (case,), _ = compiled(scene(text_of(KAPLA, 0.1, 0), f"world: {{touching: {touching}}}"))
    assert (statics_summary_of(case).answer, statics_summary_of(case).within > 0.0) == (
        ("stands", True) if stands else ("falls", False)
    )
