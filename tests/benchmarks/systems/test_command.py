"""`python -m benchmarks.systems`: the table that it prints, the systems that it takes, and what it refuses."""

import re
import signal
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path

import pytest

from benchmarks.figures.data import versions
from benchmarks.systems import __main__ as command
from stackdsl.entry_points import offered_systems
from stackdsl.simulation.plugins import distributions_of
from tests.command_line import AMPLE, Result, Stackdsl, started, write
from tests.engines_at_hand import needs_pybullet
from tests.paths import ROOT

# The second scene falls with plank floor(117.6 / 40) + 1 = 3.
SCENES = """\
scenario: flat
build:
  - column: {levels: 2}
truth:
  - stands: all
    source: closed form, nothing leans
---
scenario: stepped
build:
  - column: {levels: 3, step: 40 mm}
    every: 0.3 s
truth:
  - collapses: {at: level 3}
    source: closed form, N d <= L
"""
# The upper plank slides down into the place of the one that was pulled out.
SLIDES = """\
scenario: slides
world: {tilt: 40 deg}
build:
  - bricks: [{name: upper, at: [0 mm, 0 mm, 3.9 mm]}, {name: lower, at: [117.6 mm, 0 mm, 3.9 mm]}]
impacts:
  - at: 0 s
    remove: {brick: lower}
  - at: 0.045 s
    insert: {name: late, at: [117.6 mm, 0 mm, 3.9 mm]}
expect:
  - stands: {bricks: [late]}
"""
PROGRAM = ("-m", "benchmarks.systems")
QUICK = ("scene.yaml", "--system", "exact", "--system", "stock")
EXAMPLE = ROOT / "tests" / "plugins" / "example_engine"
Benched = Callable[..., Result]


# The command in a process that has imported most of it, where what a SystemExit says is printed as Python does.
FORKED = """
import sys
from benchmarks.systems.__main__ import main
sys.path[:0] = {path}
try:
    main()
except SystemExit as end:
    if isinstance(end.code, str):
        print(end.code, file=sys.stderr)
    raise
"""


@pytest.fixture(name="benched")
def _benched(tmp_path: Path, stackdsl: Stackdsl) -> Benched:
    """The command, called in a folder with the scenes; `path` comes before all other packages."""
    write(tmp_path, SCENES)

    def call(*arguments: str, path: Sequence[str] = ()) -> Result:
        return stackdsl(*arguments, program=FORKED.format(path=[*path]))

    return call


@needs_pybullet
def test_the_benchmark_prints_every_run_and_a_row_for_each_system_and_step(benched: Benched) -> None:
    code, out, err = benched(*QUICK)
    assert code == 0, err
    assert "[8/8]" in err
    assert [line.split()[0] for line in out.splitlines()[1:9]] == ["flat"] * 4 + ["stepped"] * 4
    assert out.splitlines()[-1].startswith("8 of 8 runs done, 0 wrong verdicts")


@needs_pybullet
def test_a_coarse_step_is_found_to_bring_down_what_stands(benched: Benched, tmp_path: Path) -> None:
    # PyBullet as it comes with four times its step: the stack falls, and statics prove that it stands.
    stack = "four_stack: {levels: 8}\n    every: 0.5 s"
    write(tmp_path, SCENES.split("---", maxsplit=1)[0].replace("column: {levels: 2}", stack))
    code, out, _ = benched("scene.yaml", "--system", "stock", "--resolutions", "4")
    assert code == 0
    assert re.search(r"flat on stock, step x 4: falls at level \d, known from truth", out)
    assert "flat on stock, step x 4: statics prove that it stands" in out
    assert "1 wrong verdict, 1 numerical collapse" in out.splitlines()[-1]


@needs_pybullet
def test_a_run_that_is_blocked_is_no_crash(benched: Benched, tmp_path: Path) -> None:
    write(tmp_path, SLIDES)
    code, out, err = benched("scene.yaml", "--system", "stock", "--resolutions", "1")
    assert (code, "'upper' has moved into its place" in out) == (0, True), out + err


@needs_pybullet
@pytest.mark.usefixtures("interruptible")
def test_an_interrupted_benchmark_prints_its_finished_runs(tmp_path: Path) -> None:
    write(tmp_path, SCENES)
    process = started(tmp_path, *QUICK, program=PROGRAM)
    assert process.stderr is not None
    assert process.stderr.readline().startswith("[1/8] ")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=AMPLE)
    assert process.returncode == 1
    assert out.splitlines()[-1].endswith("; interrupted")
    assert err.splitlines()[-1] == "interrupted"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--resolutions", "2,x"), "no list of numbers"),
        (("--resolutions", "1/0"), "no list of numbers"),
        (("--resolutions", "1,-1"), "from 1/64 to 64"),
        (("--resolutions", "65"), "from 1/64 to 64"),
        (("--system", "exmaple"), "there is no system 'exmaple'"),
    ],
)
def test_invalid_options_are_usage_errors(benched: Benched, arguments: tuple[str, ...], told: str) -> None:
    code, _, err = benched("scene.yaml", "--system", "exact", *arguments)
    assert code == 2
    assert told in err


def test_a_system_that_is_not_installed_is_told_with_what_brings_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["systems", "scene.yaml", "--system", "cra"])
    monkeypatch.setattr("stability.engines.protocol.find_spec", lambda name: None)
    with pytest.raises(SystemExit):
        command.main()
    assert "'cra' needs compas_cra, which is not installed; try: pip install '.[benchmarks]'" in capsys.readouterr().err


def test_nothing_is_played_where_a_scenario_has_a_mistake(benched: Benched, tmp_path: Path) -> None:
    write(tmp_path, "scenario: bad\nbuild: []\n", "bad.yaml")
    code, out, err = benched(".", "--system", "exact")
    assert (code, out) == (1, "")
    assert "bad.yaml:2:" in err
    assert err.endswith("there are mistakes in scenarios\n")


def test_the_default_scenarios_of_the_benchmark_exist() -> None:
    assert len(command._cases([])) > 100


# --- systems of other packages ----------------------------------------------------------------------------------------


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The example engine, installed: where its package and its entry points are."""
    facts = "site/example_engine-1.0.dist-info"
    write(tmp_path, "Metadata-Version: 2.1\nName: example-engine\nVersion: 1.0\n", f"{facts}/METADATA")
    write(tmp_path, "[stackdsl.systems]\nexample = example_engine:EXAMPLE\n", f"{facts}/entry_points.txt")
    site = str(tmp_path / "site")
    monkeypatch.syspath_prepend(site)
    offered_systems.cache_clear()
    yield [site, str(EXAMPLE)]
    offered_systems.cache_clear()


def test_a_system_of_another_package_takes_part(benched: Benched, example: list[str]) -> None:
    told = benched("scene.yaml", "--system", "example", "--system", "exact", "--resolutions", "1", path=example)
    assert told.code == 0, told.text
    assert told.out.splitlines()[-1].startswith("4 of 4 runs done, 1 wrong verdict")  # nothing tips in the example


@pytest.mark.usefixtures("example")
def test_the_version_of_what_brings_it_is_kept() -> None:
    made_with = versions(distributions_of(["exact", "example"]))
    assert made_with["example-engine"] == "1.0"
    assert made_with["numpy"] == version("numpy")
