"""A scenario written in Python, with the same keys, diagnostics and golden files as one in YAML."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Final, NoReturn

from stability.name_order import names_text
from stability.notebook import Display, Displayed, display_of
from stackdsl.api.arguments import with_remedy
from stackdsl.api.cases import ScenarioError
from stackdsl.api.run import Run, play
from stackdsl.api.written import Written, copied, spans_of, written, yaml_text
from stackdsl.checking.cases import FUNCTIONS_OF_A_CASE, PICTURES, Case, cases_of
from stackdsl.diagnostics import unknown_attribute
from stackdsl.importers.expansion import expand_file
from stackdsl.language.yaml.includes import Library
from stackdsl.language.yaml.source import Loaded, Source
from stackdsl.results import VariantResult
from stackdsl.simulation.known_systems import KNOWN
from stackdsl.trace import Event
from stackdsl.wording import how_many

TO_FILE: Final = 'write `pathlib.Path("tower.yaml").write_text(scenario.to_yaml())`'


class Scenario(Displayed):
    """A scenario: a build, impacts on it, and claims about the result.

    The parameters are the keys of a scenario in docs/language.md. Build steps come from `stackdsl.api.layouts` and
    `stackdsl.api.single_bricks`, impacts from `stackdsl.api.impacts`, and claims from `stackdsl.api.claims`. The
    scenario is validated when its cases are built or played.
    """

    @with_remedy('such as Scenario("tower", build=[layouts.column(levels=3)])')
    def __init__(
        self,
        name: str,
        *,
        build: Sequence[Written],
        description: str | None = None,
        extends: str | Mapping[str, object] | None = None,
        tags: Sequence[str] | None = None,
        brick_types: Mapping[str, Mapping[str, object]] | None = None,
        brick: str | Mapping[str, object] | None = None,
        friction: float | str | None = None,
        joints: Sequence[Mapping[str, object]] | None = None,
        world: Mapping[str, object] | None = None,
        let: Mapping[str, object] | None = None,
        uncertain: Mapping[str, object] | None = None,
        matrix: Mapping[str, Sequence[object] | str] | None = None,
        cases: Sequence[Mapping[str, object]] | None = None,
        exclude: Sequence[Mapping[str, object]] | None = None,
        impacts: Sequence[Written] | None = None,
        loads: Sequence[Mapping[str, object]] | None = None,
        supports: Sequence[Mapping[str, object]] | None = None,
        ties: Sequence[Mapping[str, object]] | None = None,
        samples: int | None = None,
        seed: int | None = None,
        confidence: str | float | None = None,
        watch: str | None = None,
        skip: str | Mapping[str, object] | None = None,
        xfail: str | Mapping[str, object] | None = None,
        systems: Sequence[str] | None = None,
        expect: Sequence[Written] | None = None,
        truth: Sequence[Written] | None = None,
    ) -> None:
        self._written = written(
            {
                "scenario": name,
                "description": description,
                "extends": extends,
                "tags": tags,
                "brick_types": brick_types,
                "brick": brick,
                "friction": friction,
                "joints": joints,
                "world": world,
                "let": let,
                "uncertain": uncertain,
                "matrix": matrix,
                "cases": cases,
                "exclude": exclude,
                "build": build,
                "impacts": impacts,
                "loads": loads,
                "supports": supports,
                "ties": ties,
                "samples": samples,
                "seed": seed,
                "confidence": confidence,
                "watch": watch,
                "skip": skip,
                "xfail": xfail,
                "systems": systems,
                "expect": expect,
                "truth": truth,
            }
        )

    @property
    def cases(self) -> tuple[Case, ...]:
        """The cases: every variant on every system. Raises ScenarioError if the scenario is invalid."""
        cases, mistakes = cases_of(expand_file(Loaded((self._source(),), ()), Library()))
        if mistakes:
            raise ScenarioError(mistakes)
        return tuple(cases)

    def play(self, case: str = "", on_event: Callable[[Event], None] = lambda event: None) -> Run:
        """Play the case whose variant, such as `step=10mm,exact`, contains the text `case`.

        A scenario with a single case needs no text. `on_event` is called with each event. Raises ScenarioError if the
        scenario is invalid, LookupError unless exactly one case matches, and BlockedPlacementError.
        """
        return play(self._case(case), on_event)

    def draw(self, case: str = "", workers: int = 1, executor: Executor | None = None) -> VariantResult:
        """Judge as many samples of a case as decide its claims; `ensemble` of the result has their counts.

        `workers` is the number of parallel processes. These may import the main module again, depending on the
        platform. With an Executor of `concurrent.futures` or of a cluster, `workers` is the number of its parallel
        calls.

        Raises the errors of `play`, and ValueError for a case without samples.
        """
        from stackdsl.checking.ensembles import sampled_result  # noqa: PLC0415 -- imports scipy

        selected = self._case(case)
        if not selected.is_sampled:
            raise ValueError(f"'{selected.name}' has no samples; give the scenario samples=1000, or call `play`")
        return sampled_result(selected, workers, executor=executor)

    def _case(self, name: str) -> Case:
        if not isinstance(name, str):
            wanted = "a part of a variant, such as 'step=10mm,exact'"
            raise TypeError(f"expected {wanted}, not {type(name).__name__}; `stackdsl.play` plays a case")
        cases = self.cases
        matching = [case for case in cases if name in case.identity.variant]
        if len(matching) == 1:
            return matching[0]
        variants = ", ".join(case.identity.variant for case in cases)
        if not matching:
            added = f"; for another system, write systems=[{name!r}]" * (name in KNOWN)
            raise LookupError(f"no case has '{name}' in its variant; the variants are {variants}{added}")
        these = f"{len(matching)} cases have '{name}' in their variants" if name else f"there are {len(cases)} cases"
        example = matching[0].identity.variant
        raise LookupError(f"{these}: {variants}; name one, such as play({example!r}), or play all with play_all()")

    def play_all(self, on_run: Callable[[Run], None] = lambda run: None) -> tuple[Run, ...]:
        """Play all cases in turn; `on_run` is called with each finished run. Raises the errors of `play`."""
        runs = []
        for case in self.cases:
            runs.append(play(case))
            on_run(runs[-1])
        return tuple(runs)

    def to_yaml(self) -> str:
        """Return the scenario as equivalent YAML."""
        return yaml_text(self._written)

    def __repr__(self) -> str:
        """Return the name; the scenario need not be valid."""
        return f"<Scenario {self._written['scenario']}>"

    if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which says what to write instead."""
            functions = (each for each in FUNCTIONS_OF_A_CASE if each != "play")
            remedies = {each: f"write `{each}(scenario)` with {each} of stackdsl" for each in functions}
            remedies |= {each: f"write `scenario.play().{each}`" for each in dir(Run) if not hasattr(Scenario, each)}
            remedies |= dict.fromkeys(PICTURES, "a notebook shows the replay of the run `scenario.play()`")
            remedies |= dict.fromkeys(("run", "simulate", "check", "judge"), "write `scenario.play()`")
            remedies |= dict.fromkeys(("save", "write", "dump", "export", "to_file"), TO_FILE)
            raise unknown_attribute(self, name, remedies)

    def _source(self) -> Source:
        spans = spans_of(self._written)
        values = copied(self._written)
        assert isinstance(values, dict)  # `Written` is a dict
        return Source(self._written.span.file, values, spans, {})


@display_of.register
def _(scenario: Scenario) -> Display:
    """Return the YAML with the cases, or with the mistakes."""
    name, text = str(scenario._written["scenario"]), scenario.to_yaml().splitlines()
    try:
        cases = scenario.cases
    except ScenarioError as error:
        return Display(name, (), "\u2717 invalid", False, aligned=[*text, "", *str(error).splitlines()])
    return Display(name, [(how_many(len(cases), "case"), names_text([c.name for c in cases]))], aligned=text)
