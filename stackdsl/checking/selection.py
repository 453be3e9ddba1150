"""Which of the gathered cases are played, and why there may be none."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from stackdsl.checking.gathering import SUFFIXES, Case
from stackdsl.diagnostics import did_you_mean
from stackdsl.systems.systems import SYSTEMS


@dataclass(frozen=True, slots=True)
class Selection:
    """Which cases to play; empty parts select everything."""

    systems: tuple[str, ...] = ()
    keyword: str = ""  # part of the name
    tags: tuple[str, ...] = ()  # any of these; with `!` in front: none of these

    def of(self, cases: Sequence[Case]) -> list[Case]:
        """The cases selected, and where a peer is asked for, each variant on it as well, after its own systems."""
        peers = [system for system in self.systems if system not in SYSTEMS]
        return [
            case
            for _, own in groupby(cases, key=lambda case: (case.scenario.scenario, case.variant.parameters))
            for case in _with(peers, list(own))
            if self.takes(case)
        ]

    def takes(self, case: Case) -> bool:
        """Whether a case is selected."""
        wanted = {tag for tag in self.tags if not tag.startswith("!")}
        unwanted = {tag[1:] for tag in self.tags if tag.startswith("!")}
        own = set(case.scenario.tags)
        return (
            (not self.systems or case.system in self.systems)
            and self.keyword.casefold() in case.name.casefold()
            and (not wanted or bool(wanted & own))
            and not unwanted & own
        )


def _with(peers: Iterable[str], cases: Sequence[Case]) -> list[Case]:
    """The cases of one variant, also on these systems."""
    return [*cases, *(replace(cases[0], system=peer) for peer in peers)]


def why_nothing(selection: Selection, cases: Sequence[Case], paths: Sequence[Path]) -> str:
    """Why nothing is selected of these cases, which were found under some paths, and what to do about it."""
    if not cases:
        where = ", ".join(map(str, paths))
        written = f"scenarios are in files that end in {' or '.join(SUFFIXES)}, and `stackdsl new NAME` writes one"
        return f"nothing selected: there is no scenario in {where}; {written}"
    reasons = list(_reasons(selection, cases)) or ["no case meets all that is asked for together"]
    return f"nothing selected: {'; '.join(reasons)}; `stackdsl check --list` names what there is"


def _reasons(selection: Selection, cases: Sequence[Case]) -> Iterator[str]:
    """What is asked for and no case has."""
    if not any(replace(selection, systems=(), tags=()).takes(case) for case in cases):
        close = did_you_mean(selection.keyword, sorted({case.scenario.scenario for case in cases}))
        yield f"no case has '{selection.keyword}' in its name{_in_brackets(close)}"
    known = sorted({tag for case in cases for tag in case.scenario.tags})
    for tag in selection.tags:
        if not tag.startswith("!") and tag not in known:
            yield f"no scenario has the tag '{tag}'{_in_brackets(did_you_mean(tag, known))}"
    if selection.systems and not any(replace(selection, keyword="", tags=()).takes(case) for case in cases):
        yield f"none is played on {' or '.join(selection.systems)}, which a scenario says by `systems:`"


def _in_brackets(remark: str) -> str:
    return f" ({remark})" if remark else ""
