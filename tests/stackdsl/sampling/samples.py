"""Designs and their samples for tests."""

from stackdsl.sampling.samples import BuildPlan, Draws, build_plan_of
from tests.scenes import timeline_of

SAMPLED = '\nsamples: 100\nexpect: [stands: {share: ">= 1 %"}]'


def designed(build: str, rest: str = "") -> BuildPlan:
    """The design of steps of a build of which some are uncertain."""
    return build_plan_of(timeline_of(build, f"{SAMPLED}\n{rest}"))


def some(count: int, first: int = 0, seed: int = 1) -> Draws:
    """So many samples."""
    return Draws(seed, "scene", first, count)
