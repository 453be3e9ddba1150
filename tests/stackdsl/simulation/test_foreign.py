"""Systems of other packages are found by their entry points and played; errors in an entry point are reported."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from importlib import import_module
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from stability.engines.protocol import World
from stability.geometry.box import Box
from stability.model import Brick, ContactPoint, Plane, Pose
from stackdsl.checking.cache import portable_digest
from stackdsl.entry_points import offered_systems
from stackdsl.simulation.plugin_world import EngineFaultError, PluginWorld
from stackdsl.simulation.plugins import distributions_of
from stackdsl.studies.sweep_plan import program_of
from tests.chromium import opened, wait_for
from tests.command_line import Result, Stackdsl, write
from tests.paths import ROOT
from tests.stackdsl.viewing.test_replay_in_chromium import press, text_of

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

EXAMPLE = ROOT / "tests" / "plugins" / "example_engine"
STANDS = "scenario: {name}\nbuild: [{{column: {{levels: 3, step: {step} mm}}}}]\nexpect: [stands: all]\n"
MAIN = "from stackdsl.__main__ import main; main()"
Install = Callable[[str, str], None]
Played = Callable[..., Result]


def column(step: float, name: str = "column") -> str:
    """KAPLA planks of 117.6 mm; three of them, each stepped by half of that and a little more, tip over."""
    return STANDS.format(name=name, step=step)


def one_line(text: str) -> str:
    """A text that a report has wrapped."""
    return " ".join(text.split())


@pytest.fixture
def install(tmp_path: Path) -> Install:
    """Puts a package on the path, as an installer leaves it: what it is called, and what its entry points are."""

    def installed(name: str, entry_points: str) -> None:
        facts = f"site/{name.replace('-', '_')}-1.0.dist-info"
        write(tmp_path, f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", f"{facts}/METADATA")
        write(tmp_path, f"[stackdsl.systems]\n{entry_points}\n", f"{facts}/entry_points.txt")

    return installed


@pytest.fixture
def beside(stackdsl: Stackdsl, tmp_path: Path) -> Played:
    """The command beside the packages that were put on the path, and the example engine."""

    def call(*arguments: str) -> Result:
        path = [str(tmp_path / "site"), str(EXAMPLE)]
        return stackdsl(*arguments, program=f"import sys; sys.path[:0] = {path}; {MAIN}")

    return call


@pytest.fixture
def example(install: Install) -> None:
    install("example-engine", "example = example_engine:EXAMPLE")


@pytest.mark.usefixtures("example")
def test_a_system_of_another_package_plays_what_it_is_asked_for(beside: Played, tmp_path: Path) -> None:
    #   Three planks stepped by 70 mm tip over, of which an engine in which nothing turns knows nothing.
    write(tmp_path, column(10.0, "stands") + "---\n" + column(70.0, "tips"))
    told = beside("check", "scene.yaml", "--system", "example")
    assert told.code == 0, told.text
    assert "2 cases: 2 passed" in told.out
    assert not (tmp_path / "golden").exists()


@pytest.mark.usefixtures("example")
def test_a_foreign_engine_drops_a_brick_onto_the_ground(beside: Played, tmp_path: Path) -> None:
    #   From 100 mm it falls for sqrt(2 h / g) = 0.143 s, and lies with its centre half a thickness over the ground.
    dropped = "bricks: [{name: one, at: [0 mm, 0 mm, 103.9 mm], drop: true}]"
    write(tmp_path, f"scenario: drop\nbuild: [{dropped}]\nexpect: [{{height: '7.8 mm ± 0.01 mm'}}]\n")
    told = beside("check", "scene.yaml", "--system", "example")
    assert told.code == 0, told.text


@pytest.mark.usefixtures("example")
def test_a_hand_on_an_engine_without_freezing_ends_the_run_with_the_missing_method(
    beside: Played, tmp_path: Path
) -> None:
    write(tmp_path, column(10.0) + "impacts: [{hold: {brick: L3.1, for: 1 s}, after: built}]\n")
    result = beside("check", "scene.yaml", "--system", "example")
    assert result.code == 5, result.text
    assert "the engine of 'example', from example-engine 1.0, failed in `ExampleWorld.freeze`" in result.out
    assert "ExampleWorld does not implement `freeze`, which a hand or a stabilizer needs" in one_line(result.out)


@pytest.mark.parametrize("name", ["example_engine.py", "pyproject.toml"])
def test_the_page_about_own_engines_shows_the_example_as_it_is(name: str) -> None:
    page = (ROOT / "docs" / "own-engine.md").read_text(encoding="utf-8")
    (shown,) = re.findall(rf"<!-- file: {re.escape(name)} -->\n```\w+\n(.*?)```", page, re.DOTALL)
    assert shown == (EXAMPLE / name).read_text(encoding="utf-8")


@pytest.mark.usefixtures("example")
def test_explain_describes_a_foreign_system(beside: Played, tmp_path: Path) -> None:
    write(tmp_path, column(10.0))
    told = beside("explain", "scene.yaml", "--system", "example")
    assert "example: bricks that only fall\n    step 1/500 s, bounces by 0\n" in told.out


@pytest.mark.usefixtures("example")
def test_a_scenario_cannot_name_it_and_is_told_how_it_is_asked_for(beside: Played, tmp_path: Path) -> None:
    write(tmp_path, column(10.0) + "systems: [example]\n")
    told = beside("check", "scene.yaml")
    assert told.code == 2
    assert "'example' is not a permitted value" in told.out
    assert "systems of other packages are chosen with --system; installed: example" in told.out


@pytest.mark.usefixtures("example")
def test_an_unknown_system_is_told_with_what_there_is(beside: Played, tmp_path: Path) -> None:
    write(tmp_path, column(10.0))
    told = beside("check", "scene.yaml", "--system", "exmaple")
    assert told.code == 4
    assert "unknown system 'exmaple' (did you mean 'example'?); known systems: exact, thesis, tuned, stock," in told.err
    assert "systems of plug-ins: example; `stackdsl doctor` lists plug-ins that failed to load" in told.err


@pytest.mark.usefixtures("example")
def test_the_doctor_tells_of_it(beside: Played) -> None:
    assert "ok     example-engine 1.0: plays example\n" in beside("doctor").out


def test_the_doctor_tells_of_one_that_is_broken(beside: Played, install: Install) -> None:
    install("broken", "nowhere = no_such_module:SYSTEM")
    told = beside("doctor")
    assert told.code == 1
    assert f"wrong  the system {BROKEN['nowhere = no_such_module:SYSTEM']}\n" in told.out


@pytest.mark.usefixtures("example")
def test_rows_of_a_sweep_are_of_the_version_of_the_package_that_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for path in (EXAMPLE, tmp_path / "site"):
        monkeypatch.syspath_prepend(str(path))
    offered_systems.cache_clear()
    try:
        assert distributions_of(["exact", "example"]) == ("example-engine",)
        assert program_of(("example",)) == portable_digest(("example-engine", "example_engine"))
    finally:
        offered_systems.cache_clear()


AGAIN = "install the package again"
BROKEN = {  # entry points, and what is told of the last one: the package, the entry point, the cause, the remedy
    "nowhere = no_such_module:SYSTEM": "'nowhere' of broken (entry point nowhere = no_such_module:SYSTEM) cannot be "
    "loaded: ModuleNotFoundError: No module named 'no_such_module'; correct the module in pyproject.toml, add it "
    f"to the modules of the package, and {AGAIN}",
    "unnamed = example_engine:NOTHING": "'unnamed' of broken (entry point unnamed = example_engine:NOTHING) cannot be "
    "loaded: AttributeError: module 'example_engine' has no attribute 'NOTHING'; define `NOTHING` in example_engine, "
    f"or correct pyproject.toml and {AGAIN}",
    "typed = example_engine:ExampleWorld": "'typed' of broken (entry point typed = example_engine:ExampleWorld) cannot "
    "be used: example_engine:ExampleWorld is of type type, but must be a stackdsl.simulation.systems.System; let the "
    f"entry point refer to a System, and {AGAIN}",
    "other = example_engine:EXAMPLE": "'other' of broken (entry point other = example_engine:EXAMPLE) cannot be used: "
    "its name is 'example', but must be the name of its entry point in stackdsl.systems; rename one of them, and "
    f"{AGAIN}",
    "tuned = example_engine:EXAMPLE\nmine = example_engine:EXAMPLE": "broken offers a system with the name 'tuned', "
    "which stackdsl reserves; uninstall broken",
}


@pytest.mark.parametrize("entry_points", BROKEN)
def test_an_error_of_a_foreign_system_is_one_line(
    beside: Played, install: Install, tmp_path: Path, entry_points: str
) -> None:
    install("broken", entry_points)
    write(tmp_path, column(10.0))
    name = entry_points.splitlines()[-1].split(" = ")[0]
    told = beside("check", "scene.yaml", "--system", name)
    assert told.code == 4
    assert told.err.splitlines()[-1].endswith(BROKEN[entry_points])


BARE = """\
from dataclasses import dataclass
from stability.engines.protocol import EngineSettings
from stackdsl.simulation.systems import System

@dataclass(frozen=True, kw_only=True)
class Bare(EngineSettings):
    def numerics(self):
        yield from ()

BARE = System("bare", "settings that do not say where the engine is", Bare(time_step=0.01), None)
"""


def test_settings_that_do_not_say_where_their_engine_is_are_refused(
    beside: Played, install: Install, tmp_path: Path
) -> None:
    install("broken", "bare = bare:BARE")
    write(tmp_path, BARE, "site/bare.py")
    write(tmp_path, column(10.0))
    told = beside("check", "scene.yaml", "--system", "bare")
    assert told.code == 4
    assert (
        "the system 'bare' of broken (entry point bare = bare:BARE) cannot be used: Bare has no `package`" in told.err
    )


# Faults of an engine, by what it does: the method that is changed, the code put before its own, the first words of the
# line that is blamed, and what is told.
FAULTS = {
    "raises an error": (
        "    def extent(",
        "        if self.clock.time > 0.0995:\n            raise RuntimeError('the solver\\ndiverged')\n",
        "            raise RuntimeError",
        "failed in `ExampleWorld.step` (site/faulty.py:{line}, at 0.100 s of the run): RuntimeError: the solver "
        "diverged",
    ),
    "returns a number that is not finite": (
        "    def fallen(",
        "        if self.clock.time > 0.0995:\n            return BodyState(Pose((0.0, 0.0, float('nan'))))\n",
        "    def states(",
        "failed in `ExampleWorld.states` (site/faulty.py:{line}, at 0.100 s of the run): the state of 'L1.1' has a "
        "number that is not finite: position_W (0, 0, nan), orientation (0, 0, 0, 1), velocity_W (0, 0, 0), "
        "angular_velocity_W (0, 0, 0)",
    ),
    "returns another type": (
        "    def states(",
        "        return list(self.bricks.values())\n",
        "    def states(",
        "failed in `ExampleWorld.states` (site/faulty.py:{line}, at 0.000 s of the run): it returned a list, but must "
        "return a mapping of names to BodyState",
    ),
    "takes a quaternion with the real part first": (
        "    def states(",
        "        places = [self.bricks[body].pose.position_W for body in bodies]\n"
        "        turned = [BodyState(Pose(place, (1.0, 0.0, 0.0, 0.0))) for place in places]\n"
        "        return dict(zip(bodies, turned))\n",
        "    def states(",
        "failed in `ExampleWorld.states` (site/faulty.py:{line}, at 0.000 s of the run): `orientation` of 'L1.1' is "
        "(1, 0, 0, 0) after `add_brick` with (0, 0, 0, 1), in the order x, y, z, w",
    ),
    "never advances its clock": (
        "    def step(",
        "        return\n",
        "    def step(",
        "failed in `ExampleWorld.step` (site/faulty.py:{line}, at 0.000 s of the run): it advanced the clock by 0 s, "
        "but must advance it by the time step, 0.002 s; call `self.clock.pass_step()` once in each `step`",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_an_engine_names_package_method_line_and_cause(
    beside: Played, install: Install, tmp_path: Path, fault: str
) -> None:
    #   Each output offers the command that shows the traceback, and no page of a run that never ended.
    method, body, blamed, told = FAULTS[fault]
    code = (EXAMPLE / "example_engine.py").read_text(encoding="utf-8").replace("example_engine", "faulty")
    head = next(line for line in code.splitlines() if line.startswith(method))
    code = code.replace(head, f"{head}\n{body}")
    line = next(n for n, text in enumerate(code.splitlines(), start=1) if text.startswith(blamed))
    write(tmp_path, code, "site/faulty.py")
    install("faulty-engine", "example = faulty:EXAMPLE")
    write(tmp_path, column(10.0))
    expected = f"the engine of 'example', from faulty-engine 1.0, {told.format(line=line)}"
    shows = "STACKDSL_DEBUG=1 stackdsl run scene.yaml --system example -k 'column[example]'"
    for command in ("check", "run"):
        result = beside(command, "scene.yaml", "--system", "example")
        assert result.code == 5, result.text
        assert f"crashed: {expected} " in one_line(result.out)
        assert f"\n  traceback {shows}\n" in result.out
        assert "--html" not in result.out
    for form in ("junit", "github"):
        assert expected in unescape(beside("check", "scene.yaml", "--system", "example", "--format", form).out)
    (whole,) = json.loads(beside("check", "scene.yaml", "--system", "example", "--format", "json").out)["results"]
    assert whole["message"] == expected
    assert whole["remedy"] == f"for the traceback: {shows}"


def test_an_engine_whose_opened_returns_nothing_is_told_so(beside: Played, install: Install, tmp_path: Path) -> None:
    code = (EXAMPLE / "example_engine.py").read_text(encoding="utf-8").replace("example_engine", "faulty")
    write(tmp_path, code.replace("return cls(", "cls("), "site/faulty.py")
    install("faulty-engine", "example = faulty:EXAMPLE")
    write(tmp_path, column(10.0))
    told = one_line(beside("check", "scene.yaml", "--system", "example").out)
    assert "failed in `ExampleWorld.opened` (site/faulty.py:" in told
    assert "it returned None, but must return the new world" in told


POINT = ContactPoint("one", "ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), gap=0.0, normal_force=1.0)
NAN = float("nan")


def odd(**wrong: Any) -> ContactPoint:  # noqa: ANN401 -- values of wrong types
    return replace(POINT, **wrong)


ODD = {  # wrong contacts of the brick `one`, and what is told of them
    "no contact": (("one", "ground"), "it returned a tuple with a str in a sequence that must hold ContactPoint only"),
    "text": (odd(position_W="here"), "`position_W` is a str, but must be a tuple of 3 numbers"),
    "an array": (
        odd(friction_W=np.zeros(3)),
        "`friction_W` is an ndarray, but must be a tuple of 3 numbers",
    ),
    "a short normal": (odd(normal_BA_W=(0.0, 1.0)), "`normal_BA_W` is a tuple of 2, but must be"),
    "a force that is nothing": (odd(normal_force=None), "`normal_force` is None, but must be a number"),
    "a force that is not finite": (odd(normal_force=NAN), "`normal_force` is nan, which is not finite"),
    "a place that is not finite": (odd(position_W=(0.0, NAN, 0.0)), "`position_W` is (0, nan, 0), which is"),
    "a pulling force": (odd(normal_force=-1.0), "`normal_force` is -1 N, but must not be negative"),
    "a long normal": (
        odd(normal_BA_W=(0.0, 0.0, 2.0)),
        "`normal_BA_W` is (0, 0, 2), but must have length 1",
    ),
    "a normal into the ground": (
        odd(normal_BA_W=(0.0, 0.0, -1.0)),
        "`normal_BA_W` is (0, 0, -1), but must point from `b`, 'ground', towards `a`, 'one'",
    ),
    "an unknown body": (odd(b="nobody"), "`a` and `b` are 'one' and 'nobody', but must be names of bodies"),
    "a contact of others": (
        odd(a="ground"),
        "are 'ground' and 'ground', but must be 'one' and another body",
    ),
}


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> World:
    """The world of the example engine, as the run sees it, with a brick on the ground."""
    monkeypatch.syspath_prepend(str(EXAMPLE))
    system = import_module("example_engine").EXAMPLE
    opened = resolve_name(system.engine.world).opened(system.engine, 9.81, 0.5)
    checked = cast(World, PluginWorld(opened, system))
    checked.add_plane(Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    checked.add_brick(Brick("one", Box((0.1, 0.1, 0.1)), 1.0), Pose((0.0, 0.0, 0.05)))
    return checked


@pytest.mark.parametrize("wrong", ODD)
def test_a_contact_with_a_wrong_value_names_the_method_the_brick_and_the_field(
    world: World, monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    #   A force of rounding size is no pull.
    point, told = ODD[wrong]
    points = [odd(normal_force=-1e-9), point]
    monkeypatch.setattr(resolve_name("example_engine:ExampleWorld"), "contacts", lambda *_: points)
    with pytest.raises(EngineFaultError, match=re.escape(told)) as error:
        world.contacts("one")
    assert "failed in `ExampleWorld.contacts` (at 0.000 s of the run): " in str(error.value)


@pytest.mark.parametrize(
    ("names", "told"), [(None, "it returned None, but must"), (["two"], "it returned 'two', which")]
)
def test_neighbours_that_are_no_bodies_of_the_world_are_a_fault(
    world: World, monkeypatch: pytest.MonkeyPatch, names: list[str] | None, told: str
) -> None:
    monkeypatch.setattr(resolve_name("example_engine:ExampleWorld"), "neighbours", lambda *_: names)
    with pytest.raises(EngineFaultError, match=told):
        world.neighbours("one", 0.01)


@pytest.mark.usefixtures("example")
def test_a_load_that_the_engine_does_not_report_is_not_measured(beside: Played, tmp_path: Path) -> None:
    write(tmp_path, column(10.0).replace("stands: all", "rests_on: {brick: L2.1, support: L1.1}"))
    told = beside("check", "scene.yaml", "--system", "example")
    assert told.code == 1, told.text
    assert "measured  not measured: the engine reports no contact force on L2.1\n" in told.out


ABSENT = "    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:"


def test_a_world_without_a_method_is_refused_and_the_doctor_says_so(
    beside: Played, install: Install, tmp_path: Path
) -> None:
    code = (EXAMPLE / "example_engine.py").read_text(encoding="utf-8").replace("example_engine", "faulty")
    write(tmp_path, code.replace(ABSENT, ABSENT.replace("push", "pusch")), "site/faulty.py")
    install("faulty-engine", "example = faulty:EXAMPLE")
    write(tmp_path, column(10.0))
    lacks = (
        "cannot be used: ExampleWorld lacks `push` (rename `pusch`?); add `def push(self, brick: BodyId, impulse_W: "
        "Vec3, at_W: Vec3) -> None`; see docs/own-engine.md"
    )
    for result in (beside("doctor"), beside("check", "scene.yaml", "--system", "example")):
        assert f"the system 'example' of faulty-engine (entry point example = faulty:EXAMPLE) {lacks}" in one_line(
            result.out
        )


def test_an_engine_that_hangs_is_named_and_its_line_can_be_shown(
    beside: Played, install: Install, tmp_path: Path
) -> None:
    code = (EXAMPLE / "example_engine.py").read_text(encoding="utf-8").replace("example_engine", "faulty")
    write(
        tmp_path,
        code.replace("        parts = self", "        while True: pass\n        parts = self"),
        "site/faulty.py",
    )
    install("faulty-engine", "example = faulty:EXAMPLE")
    write(tmp_path, column(10.0))
    result = beside("check", "scene.yaml", "--system", "example", "--time-limit", "1")
    assert result.code == 5, result.text
    told = one_line(result.out)
    assert "timed out: the engine of 'example', from faulty-engine 1.0, took longer than 1 s" in told
    assert "to see the line that hangs, interrupt the command below with Ctrl-C" in told
    assert "see it STACKDSL_DEBUG=1 stackdsl run scene.yaml --system example -k 'column[example]'" in told


@pytest.mark.usefixtures("example")
def test_a_replay_labels_a_fall_that_statics_predict_and_the_engine_does_not_show(
    beside: Played, undrawn: "Chrome", tmp_path: Path
) -> None:
    write(tmp_path, column(70.0, "tips"))
    told = beside("run", "scene.yaml", "--system", "example", "--html", "tips.html")
    assert told.code == 0, told.text
    opened(undrawn, tmp_path / "tips.html")
    fall = "L3.1 slides on L2.1; L2.1 tips over L1.1"
    wait_for(
        lambda: f"no brick fell on example. Statics predict a fall at 0.000 s: {fall}" in text_of(undrawn, "header")
    )
    press(undrawn, "Predicted fall")
    wait_for(lambda: f"Predicted by statics: {fall}" in text_of(undrawn, "footer"))


@pytest.mark.usefixtures("example")
def test_two_packages_cannot_offer_the_same_name(beside: Played, install: Install, tmp_path: Path) -> None:
    install("another", "example = example_engine:EXAMPLE")
    write(tmp_path, column(10.0))
    told = beside("check", "scene.yaml", "--system", "example")
    assert told.code == 4
    assert "offer systems with the same name 'example'; uninstall all but one" in told.err


NOBODY_ASKED = """
import sys
from click.testing import CliRunner
from stackdsl.cli.main import app
from stackdsl.entry_points import offered_systems

done = CliRunner().invoke(app, ["check", "scene.yaml", "--system", "exact", "--list"])
assert done.exit_code == 0, done.output
assert offered_systems.cache_info().currsize == 0
assert "stackdsl.simulation.plugins" not in sys.modules
"""


def test_where_none_is_asked_for_nothing_is_looked_up_and_a_broken_one_disturbs_nobody(tmp_path: Path) -> None:
    write(tmp_path, column(10.0))
    subprocess.run(
        [sys.executable, "-c", NOBODY_ASKED], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True
    )
