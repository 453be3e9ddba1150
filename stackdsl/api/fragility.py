"""Fragility curves in Python: the share of samples of a case that fall, over an intensity."""

import os
from collections.abc import Callable
from pathlib import Path

from stability.notebook import Display, display_of
from stackdsl.api.arguments import refuse_other_types, refuse_outside, with_remedy
from stackdsl.api.cases import OneCase, ScenarioError, one_case
from stackdsl.api.notebook import lines_display
from stackdsl.api.python_remedies import python_name
from stackdsl.checking.cache import ResultCache
from stackdsl.report.studies import fragility_lines
from stackdsl.studies import fragility as studied
from stackdsl.studies import fragility_request as request
from stackdsl.studies.fragility_curve import FEWEST_POINTS, Fragility


@with_remedy("such as fragility(case, over='acceleration')")
def fragility(
    case: OneCase,
    over: str,
    *,
    from_: str | None = None,
    to: str | None = None,
    points: int = request.POINTS,
    samples: int | None = None,
    seed: int | None = None,
    confidence: float | None = None,
    bearing: float | None = None,
    workers: int | None = None,
    on_done: Callable[[int], None] = lambda done: None,
) -> Fragility:
    """Return the share of samples of a case that fall at each intensity, and a lognormal curve through them.

    This is `stackdsl fragility`, with the same defaults. `over` is "friction", "acceleration", "tilt", "jitter" or the
    name of a variable. `from_` and `to` are texts with units. `bearing` is the direction of an acceleration or a tilt
    [rad], by default the worst of each sample. `workers` is the number of parallel processes, by default one per core.
    These may import the main module again, depending on the platform. `on_done` is called with the number of judged
    samples.

    Raises FragilityRequestError, a ValueError, if the case has no such curve, and RuntimeError if a process fails.
    """
    refuse_other_types(str, "a name, such as 'friction'", over=over)
    refuse_other_types(str | None, "a text with a unit, such as '5 mm'", from_=from_, to=to)
    refuse_outside("points", points, FEWEST_POINTS, request.MOST_POINTS, int)
    if confidence is not None:
        refuse_outside("confidence", confidence, request.LEAST_CONFIDENCE, request.MOST_CONFIDENCE)
    refuse_other_types(float | int | None, "a number of radians", bearing=bearing)
    refuse_other_types(int | None, "a whole number", samples=samples, seed=seed, workers=workers)
    for name, count, least in (("samples", samples, 1), ("seed", seed, 0), ("workers", workers, 1)):
        if count is not None and count < least:
            raise ValueError(f"{name} must be at least {least}, not {count}")
    known = one_case(case)
    if not known.is_sampled:
        remedy = 'give the scenario samples=1000, and a step jitter={"position": "1 mm"}'
        raise request.FragilityRequestError(f"'{known.name}' has no samples, so all runs would be the same; {remedy}")
    asked = request.FragilityRequest(over, from_, to, points, samples, seed, confidence, bearing, python_name)
    uncached = ResultCache(Path(), used=False)
    result = studied.draw(request.plan_of(known, asked), workers or os.cpu_count() or 1, uncached, on_done)
    if result.interrupted:
        raise KeyboardInterrupt
    if result.mistake is not None:
        raise ScenarioError([result.mistake])
    curve = result.fragility()
    if result.failed is not None or curve is None:
        why = (
            f"{result.failed.status}: {result.failed.message}" if result.failed is not None else "no sample was judged"
        )
        raise RuntimeError(f"{known.name}: {why}")
    return curve


@display_of.register
def _(found: Fragility) -> Display:
    return lines_display(fragility_lines(found.name, found))
