"""A scenario written in Python, with the keys, diagnostics and golden files of one in YAML."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Final

import yaml

from stackdsl.api.run import Run, ScenarioError, play
from stackdsl.api.written import Written, copied, spans_of, written
from stackdsl.checking.cases import Case, cases_of
from stackdsl.importers.expansion import expand_file
from stackdsl.language.yaml.includes import Library
from stackdsl.language.yaml.source import Loaded, Source
from stackdsl.results import VariantResult
from stackdsl.trace import Event

WIDTH: Final = 120  # [characters] of a line of YAML


class Scenario:
    """Scenario: the build, its times, the impacts, and the expected outcome.

    The parameters are the keys of a scenario in docs/language.md. Steps come from `stackdsl.api.layouts` and
    `stackdsl.api.single_bricks`, impacts and claims from the modules of these names. It is validated when it is played.
    """

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
        world: Mapping[str, object] | None = None,
        let: Mapping[str, object] | None = None,
        uncertain: Mapping[str, object] | None = None,
        matrix: Mapping[str, Sequence[object] | str] | None = None,
        cases: Sequence[Mapping[str, object]] | None = None,
        exclude: Sequence[Mapping[str, object]] | None = None,
        impacts: Sequence[Written] | None = None,
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
                "world": world,
                "let": let,
                "uncertain": uncertain,
                "matrix": matrix,
                "cases": cases,
                "exclude": exclude,
                "build": build,
                "impacts": impacts,
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
        """Return every variant on every system. Raises ScenarioError."""
        cases, mistakes = cases_of(expand_file(Loaded((self._source(),), ()), Library()))
        if mistakes:
            raise ScenarioError(mistakes)
        return tuple(cases)

    def play(self, case: str = "", on_event: Callable[[Event], None] = lambda event: None) -> Run:
        """Play the case whose variant, such as `step=10mm,exact`, contains a text; a single case needs none.

        Raises ScenarioError, LookupError if there are several such cases or none, and BlockedPlacementError.
        """
        return play(self._case(case), on_event)

    def draw(self, case: str = "", workers: int = 1, executor: Executor | None = None) -> VariantResult:
        """Judge as many samples of a case as a decision needs; `ensemble` of the result counts their outcomes.

        Raises as `play` does, and ValueError for a case without samples. Several `workers` are processes, which first
        import the main module again on platforms that start processes in this way. With an Executor of
        `concurrent.futures`, or of a cluster, `workers` is the number of calls that it runs at a time.
        """
        from stackdsl.checking.ensembles import sampled_result  # noqa: PLC0415 -- it brings scipy

        found = self._case(case)
        if not found.is_sampled:
            raise ValueError(f"'{found.name}' has no samples: give the scenario samples=1000, or play it")
        return sampled_result(found, workers, executor=executor)

    def _case(self, name: str) -> Case:
        if not isinstance(name, str):
            wanted = "the text of a variant, such as 'step=10mm,exact'"
            raise TypeError(f"expected {wanted}, not {type(name).__name__}; `stackdsl.api.run.play` plays a case")
        found = [one for one in self.cases if name in one.identity.variant]
        if len(found) != 1:
            told = ", ".join(one.identity.variant for one in self.cases)
            raise LookupError(f"'{name}' is in {len(found)} of the cases: {told}; name one, or play them by `play_all`")
        return found[0]

    def play_all(self, on_run: Callable[[Run], None] = lambda run: None) -> tuple[Run, ...]:
        """Play every case, one after the other; `on_run` is called with each run. Raises as `play` does."""
        runs = []
        for case in self.cases:
            runs.append(play(case))
            on_run(runs[-1])
        return tuple(runs)

    def to_yaml(self) -> str:
        """Return the same scenario as YAML."""
        return yaml.safe_dump(copied(self._written), sort_keys=False, allow_unicode=True, width=WIDTH)

    def _source(self) -> Source:
        spans = spans_of(self._written)
        values = copied(self._written)
        assert isinstance(values, dict)  # as the written values are
        return Source(self._written.span.file, values, spans, {})
