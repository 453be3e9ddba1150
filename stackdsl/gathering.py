"""Paths -> cases: every scenario of every file, in every variant, on every system that it names."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from stackdsl.compiling.compiler import compile_timeline
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, expand
from stackdsl.reading.source import Loaded, Source, load
from stackdsl.snapshots.snapshot import Identity
from stackdsl.timeline import Timeline

SUFFIXES = (".yaml", ".yml")


@dataclass(frozen=True, slots=True)
class Case:
    """One scenario in one variant on one system, ready to be played."""

    source: Source
    scenario: Scenario
    variant: Variant
    timeline: Timeline
    system: str

    @property
    def identity(self) -> Identity:
        """What it is called: `stepped-column`, `step=10mm,thesis`, `thesis`."""
        chosen = [f"{name}={text.replace(' ', '')}" for name, text in self.variant.parameters]
        return Identity(self.scenario.scenario, ",".join([*chosen, self.system]), self.system)

    @property
    def name(self) -> str:
        """What people call it: the scenario, then the variant in brackets."""
        return f"{self.identity.scenario}[{self.identity.variant}]"


@dataclass(frozen=True, slots=True)
class Gathered:
    """All cases in the order of files, scenarios, variants and systems; and all that is wrong with the files."""

    cases: tuple[Case, ...]
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Selection:
    """Which cases to play; empty parts select everything."""

    systems: tuple[str, ...] = ()
    keyword: str = ""  # part of the name
    tags: tuple[str, ...] = ()  # any of these; with `!` in front: none of these

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


def gather(paths: Iterable[Path]) -> Gathered:
    """Read, validate and compile everything under these paths; a directory stands for the YAML files below it."""
    cases: list[Case] = []
    diagnostics: list[Diagnostic] = []
    first: dict[str, Source] = {}
    for loaded in map(load, files_under(paths)):
        found, mistakes = cases_of(loaded)
        diagnostics += mistakes
        for source in loaded.sources:
            diagnostics += _shared_name(source, first)
        cases += found
    return Gathered(tuple(cases), tuple(diagnostics))


def files_under(paths: Iterable[Path]) -> list[Path]:
    """The files meant by these paths, each once, by name within a directory; what is no directory is left as it is."""
    found: dict[Path, None] = {}
    for path in paths:
        inside = sorted(entry for entry in path.rglob("*") if entry.suffix in SUFFIXES) if _is_folder(path) else [path]
        found |= dict.fromkeys(inside)
    return list(found)


def _is_folder(path: Path) -> bool:
    # A directory that is called like a scenario is a mistake worth telling.
    return path.is_dir() and path.suffix not in SUFFIXES


def cases_of(loaded: Loaded) -> tuple[list[Case], list[Diagnostic]]:
    """The cases of one file, and its mistakes, each told once however many variants share it."""
    cases: list[Case] = []
    mistakes = dict.fromkeys(loaded.diagnostics)
    for source in loaded.sources:
        variants, malformed = expand(source)
        mistakes |= dict.fromkeys(malformed)
        for variant in variants:
            found, wrong = _variant_cases(source, variant)
            cases += found
            mistakes |= dict.fromkeys(wrong)
    return cases, list(mistakes)


def _variant_cases(source: Source, variant: Variant) -> tuple[Sequence[Case], Sequence[Diagnostic]]:
    scenario, mistakes = validate(source, variant)
    if scenario is None:
        return (), mistakes
    timeline, misfits = compile_timeline(scenario, source)
    if timeline is None:
        return (), misfits
    return [Case(source, scenario, variant, timeline, system) for system in scenario.systems], ()


def _shared_name(source: Source, first: dict[str, Source]) -> Iterator[Diagnostic]:
    """Golden files are called by scenario, so no two may share a name."""
    name = source.values.get("scenario")
    if isinstance(name, str):
        other = first.setdefault(name, source)
        if other is not source:
            there = other.span_of(("scenario",))
            message = f"two scenarios are called '{name}'; the other one is at {there}"
            yield Diagnostic("SD203", source.span_of(("scenario",)), message, "give this one another name")
