"""Consistency of samples, uncertain values and claims."""

import pytest

from stackdsl.timeline import ErrorSpread, Jitter
from tests.scenes import compiled, mistakes_of, timeline_of

SURE = '\nsamples: 10\nexpect: [stands: {share: ">= 1 %"}]'
JITTER = "- column: {levels: 2}\n  jitter: {position: 1 mm}"


@pytest.mark.parametrize(
    ("written", "jitter"),
    [
        ("{position: 1 mm}", Jitter(ErrorSpread("normal", 0.001), None)),
        ("{position: {normal: 1 mm}}", Jitter(ErrorSpread("normal", 0.001), None)),
        (
            "{position: {uniform: 2 mm}, yaw: 0.1 rad}",
            Jitter(ErrorSpread("uniform", 0.002), ErrorSpread("normal", 0.1)),
        ),
    ],
)
def test_placement_errors_are_normal_by_default(written: str, jitter: Jitter) -> None:
    timeline = timeline_of(
        f"- column: {{levels: 2}}\n  jitter: {written}\n- column: {{levels: 1, heading: 0 deg, origin: [1 m, 0, 0]}}",
        SURE,
    )
    assert dict(timeline.jitter) == {"L1.1": jitter, "L2.1": jitter}


@pytest.mark.parametrize(
    ("build", "rest", "words"),
    [
        (JITTER, "expect: [stands: all]", "`jitter` has no effect"),
        ("- column: {levels: 2}", "seed: 4", "`seed` has no effect"),
        ("- column: {levels: 2}", "confidence: 99 %", "`confidence` has no effect"),
        ("- column: {levels: 2}", "expect: [stands: {share: 90 %}]", "`share` needs samples"),
        ("- column: {levels: 2}", SURE, "no random quantities"),
        (JITTER, "samples: 10\nexpect: [stands: all]", "`stands` without `share`"),
        (JITTER, "samples: 10\nexpect: [drift: 0 mm]", "`drift` without `share`"),
        (JITTER, SURE + "\nimpacts: [remove: {brick: L2.1}]", "cannot evaluate impacts"),
        (
            JITTER,
            SURE + "\nworld: {shake: {acceleration: 1 m/s2, frequency: 1 Hz, for: 1 s}}",
            "cannot evaluate a shaking ground",
        ),
        (JITTER + "\n  place: by hand", SURE, "cannot evaluate placement by hand"),
        ("- bricks: [{at: [0, 0, 1 m], drop: true}]\n  jitter: {yaw: 1 deg}", SURE, "cannot evaluate dropped bricks"),
        (JITTER, "samples: 10\nexpect: [stands: {share: 90 %, levels: 2}]", "cannot be combined with `levels`"),
        (JITTER, "samples: 10\nexpect: [collapses: {share: 90 %, time: 1 s ± 1 s}]", "`time` is unavailable"),
        (JITTER, "samples: 10\nexpect: [stands: {share: 120 %}]", "cannot be met by a share"),
        (JITTER, SURE.replace("10", "0"), "0 is below the minimum of 1"),
        ("- column: {levels: 2}\n  jitter: {position: 0 mm}", SURE, "0 mm"),
        ("- column: {levels: 2}\n  jitter: {yaw: 91 deg}", SURE, "91 deg"),
    ],
)
def test_contradictory_sampling_keys_are_refused(build: str, rest: str, words: str) -> None:
    mistakes = mistakes_of(build, rest)
    assert any(words in mistake.message for mistake in mistakes), [mistake.message for mistake in mistakes]
    assert all(mistake.hint for mistake in mistakes)


def test_contradicting_shares_of_samples_are_rejected() -> None:
    both = (
        "samples: 10\nexpect: [stands: {share: 40 %}, collapses: {share: 40 %}, collapses: {at: level 2, share: 9 %}]"
    )
    assert mistakes_of(JITTER, both) == []
    apart = 'samples: 10\nexpect: [stands: {share: "< 40 %"}, stands: {share: 50 %}]'
    (mistake,) = mistakes_of(JITTER, apart)
    assert "contradict each other" in mistake.message


def test_samples_of_several_variants_share_their_errors() -> None:
    """So variants differ only by the values of the matrix."""
    text = (
        f"scenario: twice\nmatrix: {{step: [0 mm, 5 mm]}}\nbuild:\n  - column: {{levels: 2, step: '${{step}}'}}\n"
        f"    jitter: {{position: 1 mm}}\n{SURE}"
    )
    cases, mistakes = compiled(text)
    assert mistakes == []
    assert [case.is_sampled for case in cases] == [True, True]
