"""Scenarios with joints: verdicts, load factors and proven collapses, as the commands print them."""

import json
from pathlib import Path

import pytest

from stability.problem import Stability
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.exits import ExitCode
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.trace import BrickState
from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.scenes import compiled

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

# Three blocks of 0.2 kg glued end to end out of a wall: tension w h^2 / (9 W L) = 7.0789 at 0.1 MPa.
CORBEL = """\
scenario: corbel
brick_types:
  block: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
brick: block
world:
  walls: [{bearing: 180 deg, distance: 0 m}]
joints:
  - bond: {tension: 0.1 MPa, cohesion: 2 MPa}
build:
  - bricks:
      - {at: [100 mm, 0 mm, 1 m], name: a}
      - {beside: a, towards: 0 deg, name: b}
      - {beside: b, towards: 0 deg, name: c}
    every: 1 s
expect:
  - stands: all
  - verdict: stable
  - margin: {load_factor: ">= 7.07"}
"""
WEAK = CORBEL.replace("0.1 MPa", "0.01 MPa")
FACTOR = 1e5 * 0.1 * 0.05**2 / (9.0 * 0.2 * 9.81 * 0.2)


def test_joined_bricks_stand_with_a_load_factor_and_the_joint_that_gives_way(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, CORBEL, "corbel.yaml")
    told = stackdsl("run", "corbel.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "measured 3 bricks stand, also under 7.079 times their weight" in told.out
    assert "expected load_factor >= 7.07, measured load_factor 7.079" in told.out
    explained = stackdsl("explain", "corbel.yaml").out
    assert "joint of all bodies: bond of 0.1 MPa tension, 2 MPa cohesion" in explained
    assert "it survives 7.07 times its own weight; a horizontal acceleration of 13.9 g" in explained
    assert "beyond: a, b, c tip over wall1; the joint between wall1 and a gives way" in explained
    survived = json.loads(stackdsl("survive", "corbel.yaml", "--format", "json").out)["cases"][0]
    assert survived["load_factor"] == pytest.approx(FACTOR, rel=1e-5)
    assert survived["gives_way"] == "a, b, c tip over wall1; the joint between wall1 and a gives way"
    assert "corbel bears 7.07 times its own weight" in stackdsl("survive", "corbel.yaml").out


def test_a_missed_load_factor_fails_with_what_gives_way(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, CORBEL.replace(">= 7.07", ">= 7.08"), "corbel.yaml")
    told = stackdsl("check", "corbel.yaml", "--no-golden")
    assert told.code == ExitCode.FAILED
    assert "measured  load_factor 7.079" in told.text
    assert "the joint between wall1 and a gives way" in told.text


def test_a_collapse_of_joined_bricks_is_proven_and_played(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, WEAK, "weak.yaml")
    told = stackdsl("run", "weak.yaml")
    assert told.code == ExitCode.FAILED
    assert "2.000 s  moves      a, b, c tip over wall1" in told.out
    assert "stands: expected all, measured 3 of 3 bricks fell" in told.out
    falls = (
        WEAK[: WEAK.index("expect:")] + "expect:\n  - collapses: any\n  - verdict: unstable\n  - falls: {count: 3}\n"
    )
    write(tmp_path, falls, "falls.yaml")
    assert stackdsl("check", "falls.yaml", "--no-golden").code == ExitCode.OK


def test_samples_of_a_glued_corbel_stand_with_the_strength_that_a_closed_form_requires(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    needed = 1e5 / FACTOR
    text = CORBEL.replace("0.1 MPa", "'${strength}'")[: CORBEL.index("expect:") + 6]
    for least, most, share in ((1.0002, 1.02, ">= 90 %"), (0.98, 0.9998, "<= 10 %")):
        middle, half = 0.5 * (least + most) * needed, 0.5 * (most - least) * needed
        drawn = f"uncertain: {{strength: {middle} Pa ± {half} Pa}}\nsamples: 50\n"
        write(tmp_path, f"{text}{drawn}expect: [{{stands: {{share: '{share}'}}}}]\n", "samples.yaml")
        told = stackdsl("check", "samples.yaml", "--no-golden")
        assert told.code == ExitCode.OK, told.text


def test_a_dry_structure_that_stands_bears_any_multiple_of_its_weight(stackdsl: Stackdsl, tmp_path: Path) -> None:
    dry = "scenario: dry\nbuild: [{column: {levels: 3}}]\nexpect: [{margin: {load_factor: '>= 1e6'}}]\n"
    write(tmp_path, dry, "dry.yaml")
    told = stackdsl("run", "dry.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "measured load_factor inf" in told.out


@pytest.mark.parametrize(
    "command",
    [("sensitivities", "corbel.yaml"), ("find", "corbel.yaml", "--least", "friction")],
)
def test_commands_that_need_dry_bricks_say_so(stackdsl: Stackdsl, tmp_path: Path, command: tuple[str, ...]) -> None:
    write(tmp_path, WEAK, "weak.yaml")
    write(tmp_path, CORBEL, "corbel.yaml")
    told = stackdsl(*command)
    assert "Traceback" not in told.text
    assert "bricks with joints" in told.err


def test_bricks_that_are_neither_proven_to_stand_nor_to_fall_do_not_stand() -> None:
    # A dry block between two walls: only forces that nothing ensures could hold it.
    walls = "[{bearing: 180 deg, distance: 0.1 m}, {bearing: 0 deg, distance: 0.1 m}]"
    build = "[{bricks: [{at: [0 m, 0 m, 1 m], name: a}]}]"
    joints = "[{between: [block, ground], pull: 1 N}]"
    text = f"{CORBEL[: CORBEL.index('world:')]}world: {{walls: {walls}}}\njoints: {joints}\n"
    case = compiled(f"{text}build: {build}\nexpect: [{{stands: all}}]\n")[0][0]
    trace = play_case(case.timeline, "exact")
    assert trace.statics is not None
    assert trace.statics.stability is Stability.UNDECIDED
    assert {track.state for track in trace.tracks.values()} == {BrickState.FALLEN}  # as a dry one
    assert not judged(case, trace).passed


def test_other_systems_refuse_joints() -> None:
    timeline = compiled(CORBEL)[0][0].timeline
    for system in ("tuned", "thesis", "modified", "pybullet-exact", "mujoco-exact"):
        with pytest.raises(BlockedPlacementError, match=f"the system '{system}' plays no joints"):
            play_case(timeline, system)


# The upper brick tips over the end of the lower one long before its glue has set.
UNSET = """scenario: unset
build:
  - bricks:
      - {name: base, at: [0 mm, 0 mm, 100 mm], brick: {size: [200 mm, 100 mm, 200 mm], mass: 10 kg}}
      - {name: top, at: [150 mm, 0 mm, 230 mm], brick: {size: [200 mm, 80 mm, 60 mm], mass: 100 g}}
joints: [{of: [base, top], bond: {tension: 10 kPa, cohesion: 20 kPa, from: 2 h after placing}}]
expect: [collapses: any]
"""
# A block of 0.2 kg that juts out of a wall on a prop, glued or in mortar, and the prop that goes.
PROPPED = """\
scenario: propped
brick_types:
  block: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
brick: block
world:
  walls: [{bearing: 180 deg, distance: 0 m}]
joints:
  - {between: [beam, wall1], bond: {tension: 0.1 MPa, cohesion: 2 MPa, from: 2 h after placing}}
build:
  - bricks:
      - {on: ground, offset: [100.2 mm, 0 mm, 0 mm], name: prop}
      - {at: [100 mm, 0 mm, 75 mm], name: beam}
impacts:
  - {after: built + 3 h, remove: {brick: prop}}
expect:
  - stands: all
"""


def test_mortar_holds_once_it_has_set_and_not_before(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, PROPPED, "propped.yaml")
    told = stackdsl("run", "propped.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "2:00:00  set        beam" in told.out
    assert "3:00:00  removed    prop" in told.out
    assert "2:00:00  beam  joints have set" in stackdsl("explain", "propped.yaml").out
    early = PROPPED.replace("built + 3 h", "built + 90 min")
    write(tmp_path, early.replace("stands: all", "collapses: {brick: beam}"), "propped.yaml")
    told = stackdsl("check", "propped.yaml", "--no-golden")
    assert told.code == ExitCode.OK, told.text
    write(tmp_path, early, "propped.yaml")
    told = stackdsl("check", "propped.yaml", "--no-golden")
    assert told.code == ExitCode.FAILED
    assert "prop pulled out at 5400 s" in told.text


def test_glue_that_sets_after_a_collapse_is_left_out_with_a_warning(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, UNSET, "unset.yaml")
    told = stackdsl("check", "unset.yaml", "--no-golden")
    assert told.code == ExitCode.OK
    assert "unset.yaml:6:70: this joint, which sets at 2:00:00, is left out, since the structure collapsed" in told.text


def test_glue_and_cuts_act_at_their_times_and_the_verdict_follows_each(stackdsl: Stackdsl, tmp_path: Path) -> None:
    bond = "between: [beam, wall1], bond: {tension: 0.1 MPa, cohesion: 2 MPa}"
    glued = PROPPED.replace(f"joints:\n  - {{{bond[:-1]}, from: 2 h after placing}}}}\n", "")
    glued = glued.replace("impacts:\n", f"impacts:\n  - glue: {{{bond}}}\n")
    write(tmp_path, glued, "glued.yaml")
    told = stackdsl("run", "glued.yaml")
    assert told.code == ExitCode.OK, told.text
    assert "0.000 s  joined     beam" in told.out
    cut = glued.replace("expect:", "  - {after: impact 2 + 1 s, cut: {of: [beam, wall1]}}\nexpect:")
    write(tmp_path, cut, "glued.yaml")
    told = stackdsl("check", "glued.yaml", "--no-golden")
    assert told.code == ExitCode.FAILED
    assert "impact 3, cut at glued.yaml" in told.text
    assert "the joints of beam cut at 3:00:01" in told.text
    assert "left out" not in told.text
    weak = cut.replace("0.1 MPa, cohesion: 2 MPa", "0.1 kPa, cohesion: 2 kPa")
    write(tmp_path, weak, "glued.yaml")
    told = stackdsl("check", "glued.yaml", "--no-golden")
    assert "`cut` at 3:00:01 is left out, since the structure collapsed at 3:00:00" in told.text
    write(tmp_path, cut.replace("stands: all", "collapses: any"), "glued.yaml")
    assert stackdsl("check", "glued.yaml", "--no-golden").code == ExitCode.OK
    write(tmp_path, cut.replace("of: [beam, wall1]", "of: [prop, ground]"), "glued.yaml")
    assert "no joint holds these bodies together at 3:00:01" in stackdsl("check", "glued.yaml", "--no-golden").text
    early = glued.replace("impacts:\n  - glue", "    every: 1 s\nimpacts:\n  - at: 0 s\n    glue")
    write(tmp_path, early, "glued.yaml")
    told = stackdsl("check", "glued.yaml", "--no-golden")
    assert "no two of these bodies are in place and touch at 0 s" in told.text


def test_dry_structures_are_not_watched_for_days(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "scenario: dry\nbuild: [{column: {levels: 3}, every: 2 d}]\n", "dry.yaml")
    told = stackdsl("run", "dry.yaml")
    assert "the time of 2 days is too long" in told.err


def test_suggest_tells_the_strength_that_holds_a_falling_structure(stackdsl: Stackdsl, tmp_path: Path) -> None:
    needed = 1e4 / (FACTOR / 10.0)  # 1.4126 times 10 kPa
    write(tmp_path, WEAK, "weak.yaml")
    told = json.loads(stackdsl("suggest", "weak.yaml", "--format", "json").out)["cases"][0]["rows"]
    assert [(each["kind"], each["amount"]) for each in told] == [("joints", 1.413)]
    explained = stackdsl("explain", "weak.yaml").out
    assert "joints of 1.413 times their strength" in explained
    named = WEAK.replace("tension: 0.01 MPa", "tension: '${glue}'").replace("world:", "let: {glue: 10 kPa}\nworld:")
    write(tmp_path, named, "weak.yaml")
    assert f"glue >= {needed / 1e3:.2f} kPa instead of 10 kPa" in stackdsl("explain", "weak.yaml").out
    strong = WEAK.replace("0.01 MPa", f"{1.413e4:g} Pa")
    write(tmp_path, strong, "strong.yaml")
    assert "proven to stand" in stackdsl("explain", "strong.yaml").out
    assert "with any one of these" in stackdsl("suggest", "weak.yaml").out
    unheld = WEAK.replace("cohesion: 2 MPa", "cohesion: 0 MPa").replace("tension: 0.01", "tension: 0")
    write(tmp_path, unheld, "unheld.yaml")
    assert "no strength of the joints is large enough" in stackdsl("explain", "unheld.yaml").out
    told = stackdsl("suggest", "unheld.yaml")
    assert "no change was found" in told.text
    assert "with any one of these" not in told.text


def test_survive_tells_the_accelerations_of_joined_bricks_by_bearing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    # A block of 200 x 100 x 50 mm glued to the ground tips about each edge against its weight and the glue.
    block = """
scenario: block
brick: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
joints: [{bond: {tension: 1 kPa, cohesion: 1 MPa}}]
build: [{bricks: [{on: ground, name: a}]}]
"""
    write(tmp_path, block, "block.yaml")
    case = json.loads(stackdsl("survive", "block.yaml", "--bearings", "4", "--format", "json").out)["cases"][0]
    pressed = 1.0 + 1e3 * 0.2 * 0.1 / (0.2 * 9.81)  # weight and glue, in units of the weight
    assert [row["survives_g"] for row in case["bearings"]] == pytest.approx([4 * pressed, 2 * pressed] * 2, rel=1e-5)
    assert case["load_factor"] is None  # any
    assert case["weakest"]["survives_g"] == pytest.approx(2 * pressed, rel=1e-3)


def test_brittle_joints_have_an_elastic_load_factor_and_an_open_verdict_between_both_limits(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    brittle = CORBEL.replace("cohesion: 2 MPa", "cohesion: 2 MPa, brittle: true").replace(">= 7.07", "2.359 .. 2.361")
    write(tmp_path, brittle, "brittle.yaml")
    told = stackdsl("check", "brittle.yaml", "--no-golden")
    assert told.code == ExitCode.OK, told.text  # a third of the load factor of ductile joints
    assert "Accelerations by bearing are not computed for brittle joints" in stackdsl("survive", "brittle.yaml").out
    write(tmp_path, brittle.replace("0.1 MPa", "0.03 MPa"), "brittle.yaml")
    told = stackdsl("check", "brittle.yaml", "--no-golden")
    assert told.code == ExitCode.FAILED
    assert "brittle joints may break" in told.text
    opened = brittle[: brittle.index("expect:")].replace("0.1 MPa", "0.03 MPa")
    write(tmp_path, f"{opened}expect:\n  - verdict: undecided\n", "brittle.yaml")
    assert stackdsl("check", "brittle.yaml", "--no-golden").code == ExitCode.OK
    write(tmp_path, brittle.replace('load_factor: "2.359 .. 2.361"', "tilt: '>= 1 deg'"), "brittle.yaml")
    assert "the margin `tilt` is not computed for brittle joints" in stackdsl("check", "brittle.yaml").text
    for command in (
        ("sensitivities", "brittle.yaml"),
        ("suggest", "brittle.yaml"),
        ("find", "brittle.yaml", "--largest", "tilt"),
    ):
        write(tmp_path, brittle, "brittle.yaml")
        assert "internal error" not in stackdsl(command[0], "brittle.yaml", *command[1:]).text


def test_sensitivities_of_the_load_factor_are_those_of_its_closed_form(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, CORBEL, "corbel.yaml")
    told = json.loads(stackdsl("sensitivities", "corbel.yaml", "--of", "load_factor", "--format", "json").out)["cases"][
        0
    ]
    assert told["margin"] == pytest.approx(FACTOR, rel=1e-5)
    slopes = {each["what"]: (each["less"], each["more"]) for each in told["effects"]}
    # tension w h^2 / (9 W L), where the weights of a, b and c have levers of 1, 3 and 5 ninths
    for what, slope in {
        "strength of the joint of a on wall1": FACTOR / 100.0,
        "mass of a": -FACTOR / 9.0 / 200.0,
        "mass of c": -FACTOR * 5.0 / 9.0 / 200.0,
        "strength of the joint of c on b": 0.0,
    }.items():
        assert slopes[what] == pytest.approx((slope, slope), rel=0.02), what
    refused = stackdsl("sensitivities", "corbel.yaml")
    assert "not computed for bricks with joints; use --of load_factor" in refused.err
    write(tmp_path, "scenario: dry\nbuild: [{column: {levels: 3}}]\n", "dry.yaml")
    assert "bears any multiple of its own weight" in stackdsl("sensitivities", "dry.yaml", "--of", "load_factor").err


def test_explain_names_items_whose_kinds_never_touch(stackdsl: Stackdsl, tmp_path: Path) -> None:
    text = CORBEL.replace("joints:\n", "joints:\n  - {between: [unused, block], pull: 1 N}\n")
    text = text.replace("brick_types:\n", "brick_types:\n  unused: {size: [10 mm, 10 mm, 10 mm], mass: 1 g}\n")
    write(tmp_path, text, "idle.yaml")
    idle, used = [line for line in stackdsl("explain", "idle.yaml").out.splitlines() if line.startswith("  joint ")]
    assert idle.endswith("pull of 1 N at each corner; no two of these touch when they are set down")
    assert "touch" not in used
