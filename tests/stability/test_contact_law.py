"""Which forces a contact can bear, as its law says, and that a law of one's own needs no more than a class."""

from dataclasses import dataclass, replace
from math import hypot

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.margins import counterweight, least_friction
from stability.analysis.placement_margin import placement
from stability.analysis.uniqueness import outcome
from stability.contact_law import ContactLaw, Coulomb, MohrCoulomb, Numbers, OtherLawError
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import UP, Contact, Forces, Motion, Placed, Problem, Tolerances, Wrench
from stability.statics.equilibrium import balance
from stability.statics.initial_motion import start_equations
from stability.statics.load_core import carries_upright
from stability.statics.proof import check_forces, check_motion, least_separating_speed
from tests.stability.statics.hand_built import column

EXACT = Tolerances()
WEIGHT = 8.0  # [N] of the plank that hangs


@dataclass(frozen=True, slots=True)
class Glue(ContactLaw):
    """Coulomb's cone with its tip at a pull: each point bears that much, and rubs as if it were pressed by it."""

    is_cone = False
    is_shifted_cone = True
    pull: Numbers  # [N]

    @property
    def least_normal(self) -> Numbers:
        """The pull."""
        return -self.pull

    @property
    def borders(self) -> tuple[tuple[Numbers, Numbers], ...]:
        """The side of the cone."""
        return ((self.friction * self.pull, self.friction),)

    @property
    def unbounded(self) -> Coulomb:
        """The cone with its tip at zero."""
        return Coulomb(self.friction)

    def smooth(self) -> "Glue":
        """The same without friction."""
        return self.with_friction(0.0)

    def greatest_friction(self, normal: Numbers) -> Numbers:
        """That of the force above the tip."""
        return self.friction * (normal + self.pull)

    def lift(self, sliding: Numbers) -> Numbers:
        """That of the cone, wherever its tip is."""
        return self.friction * sliding

    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """That of the force above the tip."""
        above, rubbed = Coulomb(self.friction).project(normal + self.pull, tangential)
        return above - self.pull, rubbed

    def support(self, opening: Numbers, sliding: Numbers, press: Numbers = np.inf) -> Numbers:
        """What the tip takes, and the force above it."""
        above = Coulomb(self.friction).support(opening, sliding, press + self.pull)
        return above + self.pull * opening


sizes = st.floats(0.0, 1e3, allow_subnormal=False)
signed = st.floats(-1e3, 1e3, allow_subnormal=False)
coefficients = st.one_of(st.just(0.0), st.floats(1e-3, 10.0))
joints = st.builds(MohrCoulomb, coefficients, sizes, sizes, st.one_of(st.just(np.inf), sizes))
laws = st.one_of(coefficients.map(Coulomb), st.builds(Glue, coefficients, sizes), joints)


def scale_of(law: ContactLaw, *numbers: float) -> float:
    """What rounding is a share of."""
    return float((1.0 + law.friction) * (sum(map(abs, numbers)) + abs(law.least_normal) + 1e-300))


def test_a_contact_pushes_and_rubs_by_a_share_of_its_push() -> None:
    law = Coulomb(0.5)
    assert law.violation(10.0, 5.0) == 0.0
    assert law.violation(10.0, 6.0) == 1.0
    assert law.violation(-2.0, 0.0) == 2.0
    assert law.interior(10.0, 4.0)
    assert not law.interior(10.0, 5.0)
    assert not Coulomb(0.0).interior(10.0, 0.0)  # without friction there is no more than a line of forces


def test_a_block_slides_up_at_no_cost_where_it_lifts_by_friction_times_its_slide() -> None:
    law = Coulomb(0.5)
    assert law.support(1.0, 2.0) == 0.0
    assert law.support(0.9, 2.0, press=30.0) == pytest.approx(3.0)  # 0.1 m/s too slow, against a push of 30 N
    assert law.support(0.9, 2.0) == np.inf


def test_glue_takes_its_pull_times_the_speed_at_which_it_is_opened() -> None:
    glue = Glue(0.5, 3.0)
    assert glue.violation(-3.0, 0.0) == glue.violation(0.0, 1.5) == 0.0
    assert glue.violation(-4.0, 0.0) == 1.0
    assert glue.support(2.0, 0.0) == 6.0


@given(laws, signed, sizes)
def test_the_projection_is_in_the_set_and_stays_where_it_is(law: ContactLaw, normal: float, tangential: float) -> None:
    there = law.project(normal, tangential)
    rounding = 1e-12 * scale_of(law, normal, tangential)
    assert law.violation(*there) <= rounding
    assert law.project(*there) == pytest.approx(there, abs=rounding)
    if law.violation(normal, tangential) == 0.0:
        assert there == pytest.approx((normal, tangential), abs=rounding)


@given(laws, signed, sizes, signed, sizes)
def test_no_force_of_the_set_is_nearer_than_the_projection(
    law: ContactLaw, normal: float, tangential: float, n: float, t: float
) -> None:
    near, other = law.project(normal, tangential), law.project(n, t)  # any force of the set
    away, along = np.subtract((normal, tangential), near), np.subtract(other, near)
    # The force lies on the far side of the plane through its projection, as the set is convex.
    assert away @ along <= 1e-11 * scale_of(law, normal, tangential, n, t) ** 2


@given(laws, signed, sizes)
def test_a_force_is_in_the_set_if_nothing_is_violated(law: ContactLaw, normal: float, tangential: float) -> None:
    there = law.project(normal, tangential)
    away = hypot(normal - there[0], tangential - there[1])
    violation = law.violation(normal, tangential)
    rounding = 1e-12 * scale_of(law, normal, tangential)
    assert violation <= (1.0 + law.friction) * away + rounding
    assert away <= hypot(1.0, 1.0) * violation * (1.0 + law.friction) + rounding
    assert not (violation > 0.0 and law.interior(normal, tangential))


@given(laws, signed, sizes, sizes)
def test_the_support_is_the_most_power_that_any_force_takes(
    law: ContactLaw, opening: float, sliding: float, press: float
) -> None:
    # Power is linear and the forces that press with no more are a polygon: one of its corners takes most.
    bends = [law.least_normal, press]
    if isinstance(law, MohrCoulomb) and law.friction > 0.0:
        bends += [bend for bend in [(law.shear - law.cohesion) / law.friction] if law.least_normal < bend < press]
    corners = [(n, t) for n in bends for t in (0.0, max(0.0, law.greatest_friction(n)))]
    if law.shortfall(opening, sliding) <= 0.0:  # then no bound of the press is needed, and none is used
        corners += [(n, law.greatest_friction(n)) for n in _far_bends(law)]
    most = max(tangential * sliding - normal * opening for normal, tangential in corners)
    rounding = 1e-12 * scale_of(law, press) * scale_of(law, opening, sliding)
    assert law.support(opening, sliding, press) == pytest.approx(most, abs=rounding)


def _far_bends(law: ContactLaw) -> list[float]:
    """Return the normal force at which the bound of shear begins to act, however large it is."""
    if not isinstance(law, MohrCoulomb) or law.friction == 0.0 or law.shear == np.inf:
        return []
    return [bend for bend in [(law.shear - law.cohesion) / law.friction] if bend > law.least_normal]


@given(laws, signed, sizes, st.floats(1e-3, 1e3))
def test_power_is_bounded_if_a_slip_opens_fast_enough(
    law: ContactLaw, opening: float, sliding: float, faster: float
) -> None:
    assert (law.support(opening, sliding) < np.inf) == (law.shortfall(opening, sliding) <= 0.0)
    assert law.support(law.lift(sliding) + faster, sliding) < np.inf


@given(coefficients, signed, signed, signed, st.floats(0.0, 6.3))
def test_the_set_is_round_about_the_normal(friction: float, n: float, one: float, other: float, angle: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    force = np.array([[n, one, other]])
    nearest, _ = Coulomb(friction).projection(force)
    turned, _ = Coulomb(friction).projection(force @ turn.T)
    assert turned == pytest.approx(nearest @ turn.T, abs=1e-11 * (1.0 + friction) * (abs(n) + abs(one) + abs(other)))


def test_the_derivative_of_the_projection_is_that_of_differences() -> None:
    forces = np.array([[1.0, 0.2, 0.1], [1.0, 2.0, -1.0], [-1.0, 0.3, 0.2], [-0.2, 1.0, 0.5]])
    law, step = Coulomb(np.full(4, 0.5)), 1e-6
    _, derivative = law.projection(forces)
    for part, ahead in enumerate(step * np.identity(3)):
        change = (law.projection(forces + ahead)[0] - law.projection(forces - ahead)[0]) / (2.0 * step)
        assert derivative[:, :, part] == pytest.approx(change, abs=1e-9)


def test_the_law_of_many_points_is_that_of_each() -> None:
    numbers = np.random.default_rng(1).normal(size=(3, 40))
    friction, normal, tangential = abs(numbers[0]), numbers[1], abs(numbers[2])
    law = Coulomb(friction)
    each = [Coulomb(mu) for mu in friction.tolist()]
    for of in (ContactLaw.violation, ContactLaw.shortfall):
        assert of(law, normal, tangential).tolist() == [of(*one) for one in zip(each, normal, tangential, strict=True)]


def hanging(share: float, left: float = 1.0, right: float = 1.0) -> Problem:
    """A plank glued under a ceiling by four corners, all of whose pulls together are such a share of its weight."""
    plank = Placed(Brick("plank", Box((2.0, 1.0, 0.1)), WEIGHT / 9.81), Pose((0.0, 0.0, -0.05)))
    corners = ((-left, -0.5, 0.0), (right, -0.5, 0.0), (right, 0.5, 0.0), (-left, 0.5, 0.0))
    glued = Contact("plank", "ceiling", corners, (UP,), Glue(0.5, share * WEIGHT / 4.0))
    return Problem({"plank": plank}, [glued], {"plank": Wrench((0.0, 0.0, -WEIGHT))})


def test_a_plank_hangs_from_glue_that_bears_its_weight_and_falls_from_less() -> None:
    pulled = Forces([tuple(((0.0, 0.0, -WEIGHT / 4.0),) for _ in range(4))])
    falling = Motion({"plank": ((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))})
    enough, less = hanging(1.0001), hanging(0.999)
    assert check_forces(enough, pulled, EXACT).holds
    assert not check_motion(enough, falling, EXACT).holds
    assert not check_forces(less, pulled, EXACT).holds
    assert check_motion(less, falling, EXACT).gain == pytest.approx(0.001, rel=1e-9)
    assert check_motion(less, falling, EXACT).holds


@pytest.mark.parametrize(("left", "right"), [(1.0, 1.0), (0.5, 1.0)])
@pytest.mark.parametrize(("share", "hangs"), [(0.999, False), (1.0001, True)])
def test_the_solver_finds_that_a_plank_hangs_from_glue(left: float, right: float, share: float, hangs: bool) -> None:
    # The corners nearer to the middle carry most: with arms of a and b a share b / (a + b) of the weight.
    problem = hanging(share * 2.0 * max(left, right) / (left + right), left, right)
    proof = balance(problem)
    if hangs:
        assert proof.forces is not None
        assert check_forces(problem, proof.forces, EXACT).holds
    else:
        assert proof.motion is not None
        assert check_motion(problem, proof.motion, EXACT).holds


@pytest.mark.parametrize(("strength", "margin"), [(1.5, 0.25), (3.0, 1.0)])
def test_a_glued_plank_survives_the_acceleration_that_friction_above_its_pull_bears(
    strength: float, margin: float
) -> None:
    # The ceiling presses the plank by the strength less its weight, and friction bears half of that.
    survived = acceleration(hanging(strength))
    assert survived is not None
    assert survived.value == pytest.approx(margin, rel=2e-6)  # a bound from below, to 1e-6


def test_analyses_refuse_a_law_that_they_do_not_support() -> None:
    problem = hanging(2.0)
    clipped = replace(problem, contacts=[replace(problem.contacts[0], law=MohrCoulomb(0.5, 4.0, 4.0))])
    with pytest.raises(OtherLawError, match="'ceiling' on 'plank' has the law MohrCoulomb"):
        counterweight(clipped, "plank")
    for refused, name in ((least_friction, "the margin of friction"), (outcome, "the guarantee of rest")):
        with pytest.raises(OtherLawError, match=f"{name} is not supported for bricks with joints"):
            refused(clipped)
    for analysis in (start_equations, placement):
        with pytest.raises(OtherLawError, match="supports dry friction only, not Glue"):
            analysis(problem)


@pytest.mark.parametrize(("share", "holds"), [(0.124, False), (0.126, True)])
def test_each_contact_is_checked_by_its_own_law(share: float, holds: bool) -> None:
    # A plank is lifted by half its weight off one on the ground: glue at four corners bears an eighth at each.
    lying = column([0.0, 0.0])
    weight = -lying.loads["p02"].force_W[2]
    glued = replace(lying.contacts[1], law=Glue(0.5, share * weight))
    loads = {**lying.loads, "p02": Wrench((0.0, 0.0, 0.5 * weight))}
    problem = replace(lying, contacts=[lying.contacts[0], glued], loads=loads)
    eighth = 0.125 * weight
    forces = Forces([(((0.0, 0.0, each),),) * 4 for each in (eighth, -eighth)])
    rising = Motion({"p02": (UP, (0.0, 0.0, 0.0))})
    assert check_forces(problem, forces, EXACT).holds == holds
    assert check_motion(problem, rising, EXACT).holds != holds


def test_proofs_are_not_added_on_a_contact_that_bears_no_sum_of_forces() -> None:
    flat = Contact("p01", "p02", ((0.0, 0.0, 0.008),), (UP,), Coulomb(0.5))
    assert carries_upright(flat)
    assert not carries_upright(replace(flat, law=Glue(0.5, 1.0)))


def test_no_motion_separates_glued_contacts() -> None:
    lying = column([0.0, 0.0])
    rising = Motion({"p01": (UP, (0.0, 0.0, 0.0)), "p02": ((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))})
    assert least_separating_speed(lying, rising) > 0.0
    glued = [replace(contact, law=Glue(0.5, 1.0)) for contact in lying.contacts]
    assert least_separating_speed(replace(lying, contacts=glued), rising) == -np.inf
