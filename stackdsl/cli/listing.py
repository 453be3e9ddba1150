"""Lists of cases that `stackdsl check` does not play: their names, or the verdicts of statics."""

import json
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby

import click

from stackdsl.checking.cases import CaseSurvey, Listed
from stackdsl.cli.options import Output, complain
from stackdsl.cli.terminal import paper, write, write_data
from stackdsl.report.statics import StaticsSummary, statics_summary_of, statics_text

FORMAT = 1  # version of the JSON output; increased like that of the report


def tell_cases(found: CaseSurvey, selected: Sequence[Listed], outputs: Sequence[Output]) -> None:
    """Write the names of cases, one per line, or as JSON with all properties used for selection."""
    complain(found.diagnostics)
    _write(outputs, "--list", lambda: "".join(f"{case.name}\n" for case in selected), lambda: _listed(selected))


def _listed(selected: Sequence[Listed]) -> Mapping[str, object]:
    cases = [
        {
            "name": case.name,
            "scenario": case.scenario_name,
            "variant": case.identity.variant,
            "system": case.system,
            "parameters": dict(case.parameters),
            "tags": list(case.tags),
            "file": case.file,
            "line": case.lines[0],
        }
        for case in selected
    ]
    return {"format": FORMAT, "cases": cases}


def tell_statics(found: CaseSurvey, selected: Sequence[Listed], outputs: Sequence[Output]) -> None:
    """Write the verdict of statics on each variant, which does not depend on the system."""
    complain(found.diagnostics)
    variants = groupby(selected, key=lambda case: (case.scenario_name, case.parameters))
    said = [statics_summary_of(next(own).compiled()) for _, own in variants]
    _write(outputs, "--statics", lambda: statics_text(said, *paper()), lambda: _proofs(said))


def _proofs(said: Sequence[StaticsSummary]) -> Mapping[str, object]:
    variants = [
        {
            "scenario": each.scenario,
            "variant": each.variant,
            "bricks": each.bricks,
            "proven": each.proven,
            "statics": each.answer,
            "reason": each.reason or None,
            "time_s": each.time,
        }
        for each in said
    ]
    return {"format": FORMAT, "variants": variants}


def _write(
    outputs: Sequence[Output], option: str, text: Callable[[], str], value: Callable[[], Mapping[str, object]]
) -> None:
    for output in outputs:
        if output.form not in ("text", "json") or output.file is not None:
            raise click.UsageError(f"{option} prints text or json, not {output}; change --format")
        if output.form == "text":
            write(text())
        else:
            write_data(json.dumps(value(), indent=2) + "\n", output.form)
