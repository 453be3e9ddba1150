"""Scenes whose limit is known from outside: a closed form, or a program that shares nothing with `stability`.

L length, w width, t thickness of a KAPLA plank; c the cotangent of an angle to the level; N planks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan, degrees, floor, radians, tan

from scipy.optimize import brentq

from stackdsl.checking.cases import Case, cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.studies.find_limit import Want
from tests.stackdsl.language.layouts.thrust_lines import least_thickness

L, W, T = 0.1176, 0.0234, 0.0078  # [m]


@dataclass(frozen=True)
class Known:
    """One scene, what is asked of it, and what is known."""

    want: Want
    name: str
    text: str  # of the scenario, without its name
    limit: Callable[[], float]  # in the unit in which it is found
    source: str

    def case(self) -> Case:
        """The scene, ready to be asked."""
        cases, mistakes = cases_of(parse(f"scenario: known\n{self.text}", "known.yaml"))
        assert not mistakes, mistakes
        return cases[0]


def cot(angle: float) -> float:
    """Of an angle in degrees."""
    return 1.0 / tan(radians(angle))


def rough_ladder(angle: float, wall: float) -> float:
    """The friction of the floor, slipping at both ends."""
    return (cot(angle) - T / L) / (2.0 + wall * (cot(angle) + T / L))


def card_house(angle: float, planks: int) -> float:
    """The friction with which a card house of two levels carries planks on top: see its scenario in user_test."""
    c, e, load = cot(angle), T / L * cot(angle), 0.5 * (3.0 + planks)
    alone = 0.5 * (c - T / L)

    def lacking(friction: float) -> float:
        k = (c + friction) / (1.0 - c * friction)
        return float(2.0 * alone * (1.0 + load) - 2.0 * alone / (1.0 - k * c) - friction * load * (1.0 + e))

    return float(brentq(lacking, 0.1, 0.5, xtol=1e-14))


LEANING = """
world:
  ground: {friction: "${rough}"}
  walls: [{bearing: 0 deg, distance: "${length * cos(angle)}", friction: "${wall}"}]
let: {length: 117.6 mm, thickness: 7.8 mm, angle: 50 deg, rough: 0.6, wall: WALL}
build:
  - bricks:
      - name: ladder
        at:
          - ${(length * cos(angle) - thickness * sin(angle)) / 2}
          - 0 mm
          - ${(length * sin(angle) + thickness * cos(angle)) / 2}
        rotate: [0 deg, "${0 deg - angle}", 0 deg]
"""
V = """
let: {length: 117.6 mm, thickness: 7.8 mm, angle: 65 deg}
build:
  - bricks:
      - name: left
        at:
          - ${0 mm - (length * cos(angle) + thickness * sin(angle)) / 2}
          - 0 mm
          - ${(length * sin(angle) + thickness * cos(angle)) / 2}
        rotate: [0 deg, "${0 deg - angle}", 0 deg]
      - name: right
        at:
          - ${(length * cos(angle) + thickness * sin(angle)) / 2}
          - 0 mm
          - ${(length * sin(angle) + thickness * cos(angle)) / 2}
        rotate: [0 deg, "${angle}", 0 deg]
"""
ARCH = "friction: 5\nbuild:\n  - arch: {span: 1 m, thickness: 130 mm, voussoirs: STONES, depth: 100 mm}\n"
HOUSE = """
friction: 0.4
let: {storey: "${117.6 mm * sin(70 deg) + 7.8 mm * cos(70 deg)}"}
build:
  - card_house: {levels: 2, angle: 70 deg}
  - column: {levels: 3, origin: [0 mm, 0 mm, "${2 * storey + 7.8 mm}"]}
    name: top
    every: 1 s
"""
# The beam turns about the end of the block, 30 mm from its middle: what lies 50 mm out there is held by itself, and by
# what lies 20 mm behind its middle.
SEESAW = """
build:
  - bricks:
      - {name: block, at: [0 mm, 0 mm, 5 mm], brick: {size: [60 mm, 40 mm, 10 mm], mass: 20 g}}
      - {name: beam, at: [10 mm, 0 mm, 15 mm], brick: {size: [160 mm, 40 mm, 10 mm], mass: 30 g}}
      - {name: back, at: [-20 mm, 0 mm, 25 mm], brick: {size: [20 mm, 40 mm, 10 mm], mass: 3 g}}
      - {name: load, at: [80 mm, 0 mm, 25 mm], brick: {size: [20 mm, 40 mm, 10 mm], mass: LOAD g}}
"""
BALCONY = "build:\n  - column: {levels: 3}\n  - bricks: [{name: arm, at: [70 mm, 0 mm, 27.3 mm]}]\n"
CARTON = "build:\n  - bricks: [{at: [0 m, 0 m, 0.25 m], brick: {size: [0.3 m, 0.2 m, 0.5 m], mass: 4 kg}}]\n"
SLAB = "friction: 0.37\nworld: {tilt: 25 deg}\nbuild:\n  - bricks: [{at: [0 mm, 0 mm, 3.9 mm]}]\n"
TILTED = "world: {tilt: {angle: 6 deg, towards: 90 deg}}\nbuild:\n  - column: {levels: 20}\n"

KNOWN = {
    "stepped column of 14, step in mm": Known(
        Want.LARGEST, "step", "build:\n  - column: {levels: 14, step: 12 mm}\n", lambda: 1000.0 * L / 14.0, "L / N"
    ),
    "stepped column by 12 mm, levels": Known(
        Want.MOST,
        "levels",
        "build:\n  - column: {levels: 14, step: 12 mm}\n    every: 1 s\n",
        lambda: floor(L / 0.012),
        "L / d, rounded down",
    ),
    "harmonic stack of 11, share of its overhangs": Known(
        Want.LARGEST, "share", "build:\n  - harmonic: {bricks: 11, share: 0.97}\n", lambda: 1.0, "1"
    ),
    "corbel of 8, share of its overhangs": Known(
        Want.LARGEST, "share", "build:\n  - corbel: {levels: 8, share: 103 %}\n", lambda: 100.0, "100 %"
    ),
    "plank that reaches out, in mm": Known(Want.LARGEST, "x of arm", BALCONY, lambda: 500.0 * L, "L / 2"),
    "slab of friction 0.37, tilt in deg": Known(Want.LARGEST, "tilt", SLAB, lambda: degrees(atan(0.37)), "tan a = mu"),
    "slab at 25 deg, friction": Known(Want.LEAST, "friction", SLAB, lambda: tan(radians(25.0)), "mu = tan a"),
    "column of 20 built on a slope, tilt in deg": Known(
        Want.LARGEST, "tilt", TILTED, lambda: degrees(atan(W / (20.0 * T))), "tan a = w / (N t)"
    ),
    "column on a slope of 6 deg, levels": Known(
        Want.MOST, "levels", TILTED, lambda: floor(W / T / tan(radians(6.0))), "w / (t tan a), rounded down"
    ),
    "finished column of 20, tilt in deg": Known(
        Want.LARGEST, "tilt", "build:\n  - column: {levels: 20}\n", lambda: degrees(atan(W / (20.0 * T))), "w / (N t)"
    ),
    "tall carton, acceleration in g": Known(Want.LARGEST, "acceleration", CARTON, lambda: 0.4, "width / height"),
    "ladder on a smooth wall, friction": Known(
        Want.LEAST, "rough", LEANING.replace("WALL", "0"), lambda: 0.5 * (cot(50.0) - T / L), "(c - t / L) / 2"
    ),
    "ladder on a rough wall, friction of the floor": Known(
        Want.LEAST,
        "rough",
        LEANING.replace("WALL", "0.3"),
        lambda: rough_ladder(50.0, 0.3),
        "(c - t / L) / (2 + f (c + t / L))",
    ),
    "inverted V, friction": Known(Want.LEAST, "friction", V, lambda: 0.5 * (cot(65.0) - T / L), "(c - t / L) / 2"),
    "inverted V of friction 0.5, angle in deg": Known(
        Want.LEAST, "angle", V, lambda: degrees(atan(1.0 / (1.0 + T / L))), "c = 2 mu + t / L"
    ),
    "card house under three planks, friction": Known(
        Want.LEAST, "friction", HOUSE, lambda: card_house(70.0, 3), "user_test/card-house.yaml"
    ),
    "beam on a block, load in g": Known(
        Want.LARGEST,
        "mass of load",
        SEESAW.replace("LOAD", "10"),
        lambda: (30.0 * 20.0 + 3.0 * 50.0) / 50.0,
        "moments about the end",
    ),
    "beam on a block, counterweight in g": Known(
        Want.LEAST,
        "mass of back",
        SEESAW.replace("LOAD", "17"),
        lambda: (17.0 * 50.0 - 30.0 * 20.0) / 50.0,
        "moments about the end",
    ),
    "arch of 8 stones, thickness in mm": Known(
        Want.LEAST,
        "thickness",
        ARCH.replace("STONES", "8"),
        lambda: 1000.0 * least_thickness(1.0, 0.5, 8),
        "line of thrust, a linear program",
    ),
    "arch of 40 stones, thickness in mm": Known(
        Want.LEAST,
        "thickness",
        ARCH.replace("STONES", "40"),
        lambda: 1000.0 * least_thickness(1.0, 0.5, 40),
        "line of thrust, a linear program",
    ),
}
