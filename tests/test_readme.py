"""What the README promises, run."""

import re
import subprocess
import sys

import pytest

from stackdsl.checking.check import play_case
from stackdsl.checking.gathering import cases_of
from stackdsl.judging.judge import judge
from stackdsl.reading.source import parse
from tests.engines_at_hand import needs_pybullet
from tests.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str, number: int = 0) -> str:
    found: list[str] = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    return found[number]


def printed(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_two_commands_stand_at_the_top() -> None:
    assert [line.split("#")[0].strip() for line in block("sh").splitlines()] == ["make check", "make test"]
    assert README.index("make test") < 400


LANGUAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
BLOCKS: list[str] = re.findall(r"```yaml\n(.*?)```", README + LANGUAGE, re.DOTALL)
WHOLE_SCENARIOS = [text for text in BLOCKS if re.search(r"^scenario:", text, re.MULTILINE)]


@pytest.mark.parametrize("text", WHOLE_SCENARIOS)
def test_the_example_scenarios_do_what_they_say(text: str) -> None:
    assert len(WHOLE_SCENARIOS) == 3
    cases, mistakes = cases_of(parse(text, "README.md"))
    assert mistakes == []
    for case in cases:
        trace = play_case(case.timeline, case.system)
        assert all(o.passed for o in judge(trace, case.scenario, case.variant, case.source, case.system))


def test_statics_alone_says_what_stands_and_what_falls() -> None:
    lines = printed(block("python")).splitlines()
    assert all(line.startswith("stable ") for line in lines[:5])
    assert lines[5].startswith("('plank3',) Margins(")
    assert lines[6].startswith("unstable far tips over plank4 ('far',)")


@needs_pybullet
def test_the_extension_attaches_to_a_users_own_world() -> None:
    assert "20 bricks are proven to stand, 0 still move" in printed(block("python", 1))
