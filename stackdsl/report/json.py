"""The report for other programs.

Keys are sorted and end in their unit, all SI. A number that is not finite is null, as is what was not measured.
`format` is raised when a key changes its meaning or goes; keys may be added without.
"""

import json
from math import isfinite

from stability.engines.friction_told import WrongFriction
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.ensemble import Ensemble
from stackdsl.observations import Change, Seen
from stackdsl.outcome import GoldenResult, Outcome, Report, Spared, VariantResult, Why, exit_code
from stackdsl.report.quantity_text import quantity_of
from stackdsl.trace import Collapse, Cost, Passed, WrongEdges

FORMAT = 1


def report_json(report: Report) -> str:
    """The whole report as one JSON object, in the report's order of variants."""
    whole = {
        "format": FORMAT,
        "exit_code": int(exit_code(report)),
        "interrupted": report.interrupted,
        "wall_time_s": _number(report.wall_time),
        "scenarios": report.scenarios,
        "conclusions": dict(report.conclusions),
        "diagnostics": [_diagnostic(diagnostic) for diagnostic in report.diagnostics],
        "results": [_result(report, result) for result in report.results],
        "obsolete": list(report.obsolete),
        "removed": list(report.removed),
        "accept": report.accept or None,
        "not_played": report.left,
    }
    text = json.dumps(whole, indent=2, sort_keys=True, allow_nan=False)
    return text.replace("\x7f", "\\u007f") + "\n"  # the only character that ASCII has and a terminal obeys


def _number(value: float | None) -> float | None:
    return value if value is not None and isfinite(value) else None


def _span(span: Span) -> dict[str, object]:
    return {"file": span.file, "line": span.line, "column": span.column, "end_column": span.end_column}


def _diagnostic(diagnostic: Diagnostic) -> dict[str, object]:
    return {
        "code": diagnostic.code,
        "message": diagnostic.message,
        "hint": diagnostic.hint,
        "span": _span(diagnostic.span),
        "repetition": diagnostic.span.where or None,
    }


def _result(report: Report, result: VariantResult) -> dict[str, object]:
    return {
        "scenario": result.scenario,
        "variant": result.variant,
        "system": result.system,
        "file": result.file,
        "status": result.status.value,
        "conclusion": result.conclusion,
        "unchecked": result.unchecked,
        "xfail": None if result.xfail is None else {"reason": result.xfail, "strict": result.strict},
        "set_aside": result.set_aside,
        "message": result.message,
        "warnings": [{"message": w.message, "hint": w.hint, "span": _span(w.span)} for w in result.warnings],
        "mistake": _diagnostic(result.mistake) if result.mistake else None,
        "variables": {name: quantity_of(written) for name, written in result.parameters},
        "remembered": result.remembered,
        "verdict": result.verdict or None,
        "numerical": result.numerical or None,
        "wrong_edges": _wrong_edges(result.wrong_edges) if result.wrong_edges else None,
        "wrong_friction": _wrong_friction(result.wrong_friction) if result.wrong_friction else None,
        "touching_within_m": _number(result.touching_within) or None,
        "passed_through": _passed(result.passed_through) if result.passed_through else None,
        "energy_gained": _number(result.energy_gained) or None,
        "collapse": _collapse(result.collapse) if result.collapse else None,
        "samples": _samples(result.ensemble) if result.ensemble else None,
        "still_moving": list(result.moving),
        "early_end": _early_end(result.early_end) if result.early_end else None,
        "drift_m": _number(result.drift),
        "engine": result.engine or None,
        "modified": result.modified or None,
        "cost": _cost(result.cost) if result.cost else None,
        "speed_up": _number(report.speed_up(result)),
        "why": _why(result.why) if result.why else None,
        "expectations": [_outcome(outcome) for outcome in result.outcomes],
        "truths": [_outcome(outcome) for outcome in result.truths],
        "refinement": None if result.refinement is None else [_change(change) for change in result.refinement],
        "golden": _golden(result.golden) if result.golden else None,
    }


def _change(change: Change) -> dict[str, object]:
    return {
        "observation": change.name,
        "unit": change.unit,
        "coarse": _seen(change.before),
        "fine": _seen(change.after),
        "difference": _number(change.difference),
        "moved": change.moved,
    }


def _seen(value: Seen) -> object:
    return list(value) if isinstance(value, tuple) else value


def _wrong_edges(wrong: WrongEdges) -> dict[str, object]:
    return {
        "contacts": wrong.contacts,
        "upper": wrong.upper,
        "lower": wrong.lower,
        "angle_rad": _number(wrong.angle),
        "time_s": _number(wrong.time),
        "first_s": _number(wrong.first),
    }


def _wrong_friction(wrong: WrongFriction) -> dict[str, object]:
    return {
        "between": [wrong.one, wrong.other],
        "asked": _number(wrong.asked),
        "had": _number(wrong.had),
        "time_s": _number(wrong.time),
    }


def _passed(passed: Passed) -> dict[str, object]:
    return {
        "brick": passed.brick,
        "through": passed.through,
        "time_s": _number(passed.time),
        "travel_m": _number(passed.travel),
    }


def _collapse(collapse: Collapse) -> dict[str, object]:
    return {
        "time_s": _number(collapse.time),
        "level": collapse.level,
        "step": collapse.step or None,
        "brick": collapse.brick,
        "gave_way": collapse.gave_way,
        "broke_at_level": collapse.broke,
    }


def _samples(ensemble: Ensemble) -> dict[str, object]:
    return {
        "drawn": ensemble.drawn,
        "planned": ensemble.planned,
        "seed": ensemble.seed,
        "stood": ensemble.stood,
        "fell_at_level": {str(level): count for level, count in ensemble.fell.items()},
        "undecided": ensemble.undecided,
        "no_place": ensemble.unfit,
        "ways": dict(ensemble.ways),
        "cpu_time_s": _number(ensemble.cpu_time),
    }


def _early_end(early: Spared) -> dict[str, object]:
    return {"time_s": early.time, "planned_s": early.planned, "actions_left_out": early.actions}


def _why(why: Why) -> dict[str, object]:
    return {
        "cause": why.cause or None,
        "moving": list(why.moving),
        "bearing_rad": _number(why.bearing),
        "overhang_m": _number(why.overhang),
        "action_before": why.before or None,
        "moved_first": why.first or None,
        "see": why.see or None,
    }


def _cost(cost: Cost) -> dict[str, object]:
    return {
        "wall_time_s": _number(cost.wall_time),
        "simulated_time_s": _number(cost.simulated_time),
        "steps": cost.steps,
        "judgements": cost.judgements,
        "proofs": dict(cost.proofs),
        "one_by_one": cost.one_by_one,
        "update_median_s": _number(cost.updates.median) if cost.updates else None,
        "update_worst_s": _number(cost.updates.worst) if cost.updates else None,
    }


def _outcome(outcome: Outcome) -> dict[str, object]:
    return {
        "name": outcome.name,
        "expected": outcome.expected,
        "measured": outcome.measured,
        "margin": _number(outcome.margin),
        "margin_unit": outcome.unit,
        "passed": outcome.passed,
        "numbers": [
            {"value": number.value, "least": number.least, "most": number.most, "unit": number.unit}
            for number in outcome.numbers
        ],
        "span": _span(outcome.span),
    }


def _golden(golden: GoldenResult) -> dict[str, object]:
    return {
        "status": golden.status.value,
        "file": golden.file,
        "note": golden.note,
        "differences": [
            {
                "subject": difference.subject,
                "quantity": difference.quantity,
                "expected": difference.expected,
                "got": difference.got,
                "tolerance": difference.tolerance,
                "expected_number": _number(difference.numbers[0]),
                "got_number": _number(difference.numbers[1]),
                "unit": difference.unit,
            }
            for difference in golden.differences
        ],
    }
