"""The claim `protocol`: a test of a standard for loads in transport.

Sources: EUMOS 40509:2020, Test method for load unit rigidity; EN 12195-1:2010, Load restraining on road vehicles,
Calculation of securing forces. Both demand more than rigid blocks show (docs/protocols.md).
"""

from collections.abc import Collection, Mapping
from math import atan, degrees, inf, pi, tan
from typing import ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, all_of, remaining
from stackdsl.language.model_base import Shorthand, default
from stackdsl.language.quantities import InputError
from stackdsl.timeline import AccelerationTest
from stackdsl.trace import AccelerationResult, Trace
from stackdsl.wording import mm

EUMOS: Final = "eumos-40509"
EN: Final = "en-12195-1"
TILTING: Final = "tilting-table"

SIDES: Final = {"forwards": 0.0, "to the left": 0.5 * pi, "backwards": pi, "to the right": 1.5 * pi}
FORWARD, OTHERWISE = 0.8, 0.5  # [g] of EN 12195-1 on the road
USUAL: Final = 0.5  # [g] of EUMOS 40509

# Limits of EUMOS 40509, as shares of the height of the load.
ELASTIC, PERMANENT = 0.1, 0.05
LOW: Final = 0.04  # [m] of the lowest `LOW_PART`


@claim("protocol", "passes a test of a standard for loads in transport")
class Protocol(Shorthand, ClaimKind):
    """The finished structure passes the accelerations of a standard in four directions, proven by statics if it can be.

    Only EUMOS 40509 allows some displacement. Where statics does not prove a direction, its pulse is simulated.
    """

    name: Literal["eumos-40509", "en-12195-1", "tilting-table"] = Field(description="the protocol")
    forward: t.Angle = default("0 deg", "direction of travel, from +x towards +y")
    acceleration: t.PartOfG | None = Field(None, description="acceleration of `eumos-40509`; default: 0.5 g")
    angle: t.TableSlope | None = Field(None, description="tilt of `tilting-table`")

    scalar_key: ClassVar[str] = "name"
    needs_statics: ClassVar[bool] = True
    key_of: ClassVar[Mapping[str, str]] = {EUMOS: "acceleration", TILTING: "angle"}

    @model_validator(mode="after")
    def _keys_of_protocol(self) -> Self:
        for key in ("acceleration", "angle"):
            if getattr(self, key) is not None and self.key_of.get(self.name) != key:
                raise InputError("SD108", f"`{key}` does not apply to `{self.name}`", "remove it")
        if self.name == TILTING and self.angle is None:
            message = f"`angle`, the tilt of `{TILTING}`, is missing"
            raise InputError("SD102", message, f"write, for example, `protocol: {{name: {TILTING}, angle: 26 deg}}`")
        return self

    @property
    def needed_tests(self) -> Collection[AccelerationTest]:
        return [
            AccelerationTest((self.forward + angle) % (2.0 * pi), self._acceleration(side), self.name == EUMOS)
            for side, angle in SIDES.items()
        ]

    def _acceleration(self, side: str) -> float:
        """Return the acceleration that a side must bear, as a multiple of gravity."""
        if self.name == EN:
            return FORWARD if side == "forwards" else OTHERWISE
        if self.name == TILTING:
            return tan(self.angle or 0.0)
        return USUAL if self.acceleration is None else self.acceleration

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the proven acceleration of each side, or the displacements that a pulse leaves."""
        if trace.tests is None:
            standing = remaining(trace)
            lost = [name for name, track in standing if not track.frozen]
            why = f": {len(lost)} of {len(standing)} bricks are not proven to stand" if lost else ""
            text = f"no test, as the structure at rest is not proven to stand{why}"
            return ClaimResult(text, -inf, "g", passed=False)
        results = {result.test: result for result in trace.tests}
        sides = zip(SIDES, self.needed_tests, strict=True)
        parts = [self._part(side, results[test]) for side, test in sides if test in results]
        return all_of(parts) if parts else ClaimResult("not tested", -inf, "g", passed=False)

    def _part(self, side: str, result: AccelerationResult) -> ClaimResult:
        wanted = result.test.acceleration
        if result.survived >= wanted or result.motion is None:
            passed = result.survived >= wanted
            survived, due = self._shown(result.survived), self._shown(wanted)
            if passed:
                return ClaimResult(f"{side} {due} proven", result.survived - wanted, "g", passed=True)
            beyond = "is not borne" if result.fails <= wanted else "is not proven"
            why = f", then {result.gives_way}" if result.gives_way else ""
            text = f"{side} {due} {beyond}: up to {survived}{why}"
            return ClaimResult(text, result.survived - wanted, "g", passed=False)
        return _moved(side, result)

    def _shown(self, acceleration: float) -> str:
        if self.name == TILTING:
            return f"{degrees(atan(acceleration)):.4g} deg"
        return f"{acceleration:.4g} g"


def _moved(side: str, result: AccelerationResult) -> ClaimResult:
    """Compare the displacements of a simulated pulse with the limits of EUMOS 40509."""
    motion = result.motion
    assert motion is not None
    limits = (
        ("at most", motion.largest, ELASTIC * motion.height),
        ("for good", motion.permanent, PERMANENT * motion.height),
        ("in the lowest 200 mm", motion.lowest, LOW),
    )
    parts = [f"{mm(way)} {what} ({mm(limit)} allowed)" for what, way, limit in limits]
    margin = min(limit - way for _, way, limit in limits)
    fallen = f", {len(motion.fallen)} bricks fall" if motion.fallen else ""
    moving = ", still moving at the end" if motion.is_moving else ""
    text = f"{side} {result.test.acceleration:.4g} g moves it {', '.join(parts)}{fallen}{moving}"
    passed = margin >= 0.0 and not motion.fallen and not motion.is_moving
    return ClaimResult(text, 1000.0 * margin, "mm", passed=passed)
