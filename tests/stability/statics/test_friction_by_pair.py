"""Assemblies whose contacts differ in friction: limits in closed form, and a linear programme that shares nothing."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import atan, cos, pi, sin

import numpy as np
import pytest

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.margins import least_friction
from stability.contact_law import Coulomb, Friction
from stability.geometry.vectors import multiply, rotate
from stability.model import GROUND, BodyId, Plane, Pose
from stability.problem import Placed, Stability, Tolerances, Verdict
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces
from tests.stability.statics.closed_forms import brick_at, ladder, level_ground
from tests.stability.statics.independent import flat_touches, verdict_of
from tests.stability.statics.random_piles import random_pile

NEAR = 1e-6  # share of a limit, on either side of which the verdict is another
SHEET, CARTON = (0.2, 0.1, 0.002), (0.1, 0.08, 0.06)  # [m]
USUAL = 0.5


def stack(tops: Iterable[BodyId] = ("carton",)) -> list[Placed]:
    """A sheet on the ground, and cartons on it, one on the other."""
    cartons = [brick_at(name, CARTON, (0.0, 0.0, 0.032 + 0.06 * level), mass=2.0) for level, name in enumerate(tops)]
    return [brick_at("sheet", SHEET, (0.0, 0.0, 0.001), mass=0.05), *cartons]


def on_a_slope(bricks: Iterable[Placed], friction: Friction | float, tangent: float, ground: float = 0.9) -> Assembly:
    """All turned about y, so that downhill is +x."""
    half = 0.5 * atan(tangent)
    turn = (0.0, sin(half), 0.0, cos(half))
    plane = Plane(GROUND, (0.0, 0.0, 0.0), rotate(turn, (0.0, 0.0, 1.0)), ground)
    assembly = Assembly((plane,), friction)
    assembly.add_all(
        Placed(each.brick, Pose(rotate(turn, each.pose.position_W), multiply(turn, each.pose.orientation)))
        for each in bricks
    )
    return assembly


SMOOTH_SHEET = Friction(USUAL, own={"sheet": 0.1}, between={("sheet", GROUND): 0.9})
LAWS = {
    "of its own": SMOOTH_SHEET,
    "of the pair": Friction(USUAL, between={("carton", "sheet"): 0.1, (GROUND, "sheet"): 0.9}),
    "of the kinds": Friction(USUAL, between={("foil", "box"): 0.1}, kinds={"sheet": "foil", "carton": "box"}),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_on_a_slope_a_carton_slides_off_its_sheet_where_the_tangent_is_that_friction(law: Friction) -> None:
    assert on_a_slope(stack(), law, 0.1 * (1.0 - NEAR)).verdict().stability is Stability.STABLE
    slides = on_a_slope(stack(), law, 0.1 * (1.0 + NEAR)).verdict()
    assert (slides.stability, slides.moving) == (Stability.UNSTABLE, ("carton",))
    assert slides.reason == "carton slides on sheet"


def test_on_rough_ground_a_smooth_sheet_takes_all_on_it_along() -> None:
    law = Friction(USUAL, own={"sheet": 0.1}, between={("sheet", "carton"): 0.8})
    assert on_a_slope(stack(), law, 0.1 * (1.0 - NEAR)).verdict().stability is Stability.STABLE
    assert on_a_slope(stack(), law, 0.1 * (1.0 + NEAR)).verdict().moving == ("carton", "sheet")


def test_no_friction_on_level_ground_stands_and_on_the_least_slope_does_not() -> None:
    law = Friction(USUAL, own={"sheet": 0.0})
    assert on_a_slope(stack(), law, 0.0).verdict().stability is Stability.STABLE
    assert on_a_slope(stack(), law, 1e-6).verdict().stability is Stability.UNSTABLE


@pytest.mark.parametrize(("floor", "wall"), [(0.4, 0.2), (0.2, 0.7), (0.3, 0.0)])
def test_a_ladder_slips_where_it_must_with_another_friction_on_the_wall(floor: float, wall: float) -> None:
    law = Friction(0.9, between={("ladder", GROUND): floor, ("wall", "ladder"): wall})
    for share, expected in ((1.0 - NEAR, Stability.STABLE), (1.0 + NEAR, Stability.UNSTABLE)):
        structure = ladder(share, floor, wall)
        planes = [replace(plane, friction=0.05) for plane in structure.planes]  # which nobody asks
        assert Assembly(planes, law).add_all(structure.bricks).stability is expected


def test_a_shaken_brick_slides_first_on_its_sheet() -> None:
    tops = ("low", "mid", "high")
    assembly = Assembly((level_ground(0.6),), Friction(USUAL, own={"sheet": 0.1}, between={("sheet", GROUND): 0.6}))
    assembly.add_all(stack(tops))
    worst = acceleration(assembly.problem())
    assert worst is not None
    assert worst.value == pytest.approx(0.1, rel=2e-6)
    assert worst.motion is not None
    assert worst.motion.velocity.keys() == set(tops)


def test_the_margin_of_friction_is_a_factor_on_all_and_tells_the_roughest() -> None:
    margin = least_friction(on_a_slope(stack(), SMOOTH_SHEET, 0.05).problem())
    assert margin.factor == pytest.approx(0.5, rel=1e-6)
    assert margin.coefficient == pytest.approx(0.5 * 0.9, rel=1e-6)


def test_the_forces_of_the_proof_are_within_the_cone_of_each_contact_and_not_within_smaller_ones() -> None:
    assembly = on_a_slope(stack(), SMOOTH_SHEET, 0.0999)
    forces, problem = assembly.forces(), assembly.problem()
    assert forces is not None
    assert check_forces(problem, forces, Tolerances()).holds
    smoother = [replace(contact, law=Coulomb(0.99 * contact.law.friction)) for contact in problem.contacts]
    assert not check_forces(replace(problem, contacts=smoother), forces, Tolerances()).holds


def test_other_names_and_another_order_change_nothing() -> None:
    generator = np.random.default_rng(7)
    for tangent in (0.0999, 0.1001):
        bricks = stack(("a", "b", "c"))
        law = Friction(USUAL, own={"sheet": 0.3, "b": 0.2}, between={("b", "c"): 0.1, ("a", "sheet"): 0.25})
        expected = on_a_slope(bricks, law, tangent).verdict()
        names = dict(zip(("sheet", "a", "b", "c"), generator.permutation(list("wxyz")).tolist(), strict=True))
        renamed = [replace(each, brick=replace(each.brick, id=names[each.brick.id])) for each in bricks]
        again = Friction(
            USUAL,
            own={names[name]: own for name, own in list(law.own.items())[::-1]},
            between={(names[b], names[a]): each for (a, b), each in list(law.between.items())[::-1]},
        )
        found = on_a_slope(renamed[::-1], again, tangent).verdict()
        assert found.stability is expected.stability
        assert set(found.moving) == {names[name] for name in expected.moving}


def test_where_all_is_said_to_be_alike_the_verdict_is_that_of_one_coefficient_to_the_bit() -> None:
    pile = random_pile(np.random.default_rng(3), 4)
    one = Assembly(friction=0.5)
    one.add_all(pile)
    same = Friction(0.5, own={each.brick.id: 0.5 for each in pile}, between={("p00", "p01"): 0.5})
    other = Assembly(friction=same)
    other.add_all(pile)
    assert other.all_contacts() == one.all_contacts()
    assert other.forces() == one.forces()
    assert other.verdict() == one.verdict()


@dataclass(frozen=True, slots=True)
class Plainly:
    """Who has which friction on whom, said once more in another way."""

    usual: float
    ground: float
    own: Mapping[BodyId, float]
    between: Mapping[tuple[BodyId, BodyId], float]

    def asked(self, lower: BodyId, upper: BodyId) -> float:
        pair = (min(lower, upper), max(lower, upper))
        other = self.ground if lower == GROUND else self.usual
        return self.between.get(pair, min(self.own.get(name, other) for name in pair))


def piles_on_slopes(count: int) -> Iterable[tuple[Verdict, str | None]]:
    """What is said of random piles with frictions by brick and by pair, and what is certain of them."""
    for number in range(count):
        generator = np.random.default_rng([16, number])
        pile = random_pile(generator, 3 * (number % 5))  # of 3 to 12 planks
        names = [each.brick.id for each in pile]
        own = {name: float(generator.uniform(0.1, 1.0)) for name in names if generator.random() < 0.4}
        pairs = [generator.choice(names, 2, replace=False).tolist() for _ in names] if len(names) > 1 else []
        between = {(min(pair), max(pair)): float(generator.uniform(0.1, 1.0)) for pair in pairs}
        most = (1.0, 1.0, 0.3, 2.0 * pi)
        usual, rough, angle, bearing = (float(generator.uniform(0.15 * each, each)) for each in most)
        surfaces = Plainly(usual, rough, own, between)
        turn = (-sin(bearing) * sin(0.5 * angle), cos(bearing) * sin(0.5 * angle), 0.0, cos(0.5 * angle))

        touches = [
            replace(
                touch,
                points=tuple(rotate(turn, point) for point in touch.points),
                normal=rotate(turn, touch.normal),
                along=rotate(turn, touch.along),
                friction=surfaces.asked(touch.lower, touch.upper),
            )
            for touch in flat_touches(pile, usual)
        ]
        bricks = [
            Placed(each.brick, Pose(rotate(turn, each.pose.position_W), multiply(turn, each.pose.orientation)))
            for each in pile
        ]
        ground = Plane(GROUND, (0.0, 0.0, 0.0), rotate(turn, (0.0, 0.0, 1.0)), rough)
        verdict = Assembly((ground,), Friction(usual, own, between)).add_all(bricks)
        yield verdict, verdict_of({each.brick.id: each for each in bricks}, touches)


@pytest.mark.parametrize("count", [25, pytest.param(100, marks=pytest.mark.slow)])
def test_no_verdict_on_piles_with_frictions_by_pair_is_contradicted_by_the_linear_programme(count: int) -> None:
    found = list(piles_on_slopes(count))
    opposite = {Stability.STABLE: "unstable", Stability.UNSTABLE: "stable"}
    assert [number for number, (verdict, sure) in enumerate(found) if opposite.get(verdict.stability) == sure] == []
    said = [verdict.stability for verdict, _ in found]
    assert said.count(Stability.UNDECIDED) == 0
    assert min(said.count(Stability.STABLE), said.count(Stability.UNSTABLE)) > count // 5
    assert sum(sure is None for _, sure in found) < 0.1 * count
