"""A change of an assembly takes effect at once or not at all, whatever instruction an interrupt comes after."""

import copy
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

import pytest

from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability
from stability.statics import journal
from stability.statics.assembly import Assembly, AssemblyState
from tests.paths import ROOT
from tests.stability.statics.test_what_if import known, plank

FEW = 10  # interrupts a change, spread over all its instructions; many with `slow`
MANY = 400


def sheet(name: str, thick: float, x: float, z: float) -> Placed:
    return Placed(Brick(name, Box((0.06, 0.02, thick)), 0.01), Pose((x, 0.0, z + 0.5 * thick)))


def structure() -> Assembly:
    """A bridge with a plank that overhangs under a counterweight, a gap that counts as contact, a plank that tips."""
    assembly = Assembly()
    assembly.add_all([plank("left", -0.07), plank("right", 0.07), plank("bridge", level=2)])
    assembly.add_all([plank("out", 0.065, level=3), plank("weight", 0.02, level=4)])
    assembly.add_all([Placed(Brick("post", Box((0.02, 0.02, 0.008)), 0.05), Pose((0.3, 0.0, 0.004)))])
    assembly.add_all([sheet("lid", 0.002, 0.3, 0.008 + 2e-5)])
    assembly.add_all([plank("tipping", 0.065, level=2, y=0.3), plank("foot", 0.0, y=0.3)])
    assert assembly.verdict().stability is Stability.UNSTABLE
    return assembly


STRUCTURE = structure()
CHANGES: dict[str, Callable[[Assembly, AssemblyState], object]] = {  # with another state of the same assembly
    "add": lambda on, _: on.add(*_parts(plank("new", 0.0, level=5))),
    "add_all": lambda on, _: on.add_all([plank("new", 0.03, level=5), plank("newer", 0.0, level=6)]),
    "add a sheet into a gap": lambda on, _: on.add(*_parts(sheet("thin", 2e-5, 0.3, 0.008))),
    "add what falls": lambda on, _: on.add(*_parts(plank("new", 0.2, level=2, y=0.3))),
    "remove what holds others": lambda on, _: on.remove(["weight", "lid"]),
    "remove what tips": lambda on, _: on.remove(["tipping"]),
    "move": lambda on, _: on.move("weight", plank("weight", 0.01, level=4).pose),
    "move what carries": lambda on, _: on.move("right", plank("right", 0.2).pose),
    "would": lambda on, _: on.would(*_parts(plank("new", 0.0, level=5))),
    "would_all": lambda on, _: on.would_all([plank("new", 0.03, level=5), plank("newer", 0.0, level=6)]),
    "would_without": lambda on, _: on.would_without(["bridge"]),
    "restore": lambda on, state: on.restore(state),
}


def _parts(placed: Placed) -> tuple[Brick, Pose]:
    return placed.brick, placed.pose


def another() -> tuple[Assembly, AssemblyState]:
    """A copy of the structure, and a state of it with fewer bricks and others."""
    assembly = STRUCTURE.copied()
    now = assembly.state()
    assembly.remove(["weight", "lid", "foot"])
    assembly.add(*_parts(plank("foot", 0.5)))
    state = assembly.state()
    assembly.restore(now)
    return assembly, state


@contextmanager
def interrupted(after: int, within: str = "stability") -> Iterator[list[int]]:
    """Raise KeyboardInterrupt after so many instructions of files below a folder; how many there were is counted."""
    count = [0]

    def trace(frame: FrameType, event: str, _: object) -> Any:  # noqa: ANN401 -- as sys.settrace wants it
        if not frame.f_code.co_filename.startswith(f"{ROOT / within}"):
            return None
        frame.f_trace_opcodes = True
        if event == "opcode":
            count[0] += 1
            if count[0] == after:
                raise KeyboardInterrupt
        return trace

    # Python 3.12 tells of instructions only if some frame has asked for them before tracing begins.
    sys._getframe().f_trace_opcodes = True
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield count
    finally:
        sys.settrace(before)


def as_fresh(assembly: Assembly) -> bool:
    """Whether the verdict is that of an assembly into which the same bricks are put anew, in the same order."""
    fresh = Assembly(assembly.planes, assembly.friction)
    fresh.add_all(assembly.bricks.values())
    return assembly.verdict().stability is fresh.verdict().stability


def interrupt_often(name: str, times: int) -> None:
    change = CHANGES[name]
    whole, state = another()
    before = known(whole)
    with interrupted(-1) as count:
        change(whole, state)
    after = known(whole)
    broken_off = 0
    for at in range(1, count[0] + 1, max(1, count[0] // times)):
        assembly, state = another()
        try:
            with interrupted(at):
                change(assembly, state)
        except KeyboardInterrupt:
            broken_off += 1
        found = known(assembly)
        assert found in (before, after), f"after {at} instructions of {name}"
        assert as_fresh(assembly)
        if found == before:
            change(assembly, state)
            assert known(assembly) == after
    assert broken_off


@pytest.mark.parametrize("name", CHANGES)
def test_an_interrupted_change_has_taken_effect_or_it_has_not(name: str) -> None:
    interrupt_often(name, FEW)


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_however_often_a_change_is_interrupted_it_has_taken_effect_or_it_has_not(name: str) -> None:
    interrupt_often(name, MANY)


@pytest.mark.parametrize("name", ["add a sheet into a gap", "move what carries", "restore"])
def test_undoing_what_was_broken_off_may_be_broken_off_as_well(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before = known(STRUCTURE)

    def interrupt(_: journal.Journal) -> None:
        raise KeyboardInterrupt

    def broken_off(after: int) -> tuple[Assembly, int]:
        """Interrupt a change when all of it is written, and its undoing too; and how many instructions that took."""
        assembly, state = another()
        with monkeypatch.context() as patched, suppress(KeyboardInterrupt):
            patched.setattr(journal.Journal, "keep", interrupt)
            patched.setattr(journal.Journal, "undo", lambda _: None)
            CHANGES[name](assembly, state)
        with suppress(KeyboardInterrupt), interrupted(after) as count:
            assembly.bricks  # noqa: B018 -- whoever asks next
        return assembly, count[0]

    _, whole = broken_off(-1)
    assert whole > 100
    for after in range(1, whole + 1, max(1, whole // FEW)):
        assembly, _ = broken_off(after)
        assert known(assembly) == before, f"after {after} instructions"
        assert assembly.verdict() == STRUCTURE.verdict()
        assembly.remove(["tipping"])
        assert as_fresh(assembly)


@pytest.mark.parametrize("made", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_a_copy_of_an_assembly_knows_the_same_and_changes_by_itself(made: Callable[[Assembly], Assembly]) -> None:
    before = known(STRUCTURE)
    other = made(STRUCTURE)
    assert known(other) == before
    assert other.remove(["tipping"]).stability is Stability.STABLE
    other.add(*_parts(plank("new", 0.0, level=5)))
    assert known(STRUCTURE) == before
    assert "tipping" not in other.bricks


def test_a_state_that_is_copied_with_its_assembly_is_restored_in_the_copy() -> None:
    assembly = STRUCTURE.copied()
    state = assembly.state()
    assembly.remove(["tipping"])
    for other, state_there in (copy.deepcopy((assembly, state)), pickle.loads(pickle.dumps((assembly, state)))):
        other.restore(state_there)
        assert known(other) == known(STRUCTURE)
