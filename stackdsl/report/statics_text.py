"""What statics says of scenarios, before anything is played."""

from collections.abc import Sequence
from dataclasses import dataclass

from stability.statics.facts import Stability
from stackdsl.checking.gathering import Case
from stackdsl.judging.proofs import proofs_of
from stackdsl.report.blocks import Block, blocks_text, line, table
from stackdsl.timeline import Placement
from stackdsl.wording import touching_text

ANSWERS = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls"}  # of the others nothing is known
OPEN = "not proven"


@dataclass(frozen=True, slots=True)
class Said:
    """What was proven of one scenario in one variant."""

    scenario: str
    variant: str  # without a system
    bricks: int  # of the structure
    proven: int  # that stand once they are set down, and all before them
    answer: str  # `stands`, `falls` or `not proven`
    reason: str  # why not, where something falls or is in doubt
    time: float | None  # of the first placement that does not stand [s]
    within: float = 0.0  # [m] what stands counts on gaps up to this as contact; 0 if on none

    @property
    def name(self) -> str:
        """The scenario, and the variant where it has more than one."""
        return f"{self.scenario}[{self.variant}]" if self.variant else self.scenario


def said_of(case: Case) -> Said:
    """Judge each placement of a case by statics, up to the first thing that only an engine can follow."""
    timeline = case.timeline
    proofs = proofs_of(timeline)
    verdict = proofs.verdict
    bricks = sum(not placement.hits for placement in timeline.placements)
    fallen = [judged for judged in proofs.judged if judged.verdict.stability is not Stability.STABLE]
    proven = sum(len(judged.bricks) for judged in proofs.judged if judged not in fallen)
    answer = ANSWERS.get(verdict.stability, OPEN)
    reason = verdict.reason if verdict.stability is not Stability.STABLE else ""
    if answer == "stands" and proven < bricks:
        answer, reason = OPEN, f"{bricks - proven} of {bricks} bricks are left to the engine"
    first = {fallen[0].bricks[0]} if fallen else frozenset[str]()
    times = [act.time for act in timeline.actions if isinstance(act, Placement) and act.brick.id in first]
    variant = ",".join(f"{name}={text}" for name, text in case.parameters)
    return Said(
        case.scenario_name,
        variant,
        bricks,
        proven,
        answer,
        reason,
        times[0] if times else None,
        verdict.touching_within,
    )


def statics_text(said: Sequence[Said], width: int, colour: bool) -> str:
    """One row a variant, and below them why what does not stand does not."""
    if not said:
        return ""
    rows = [
        {
            "scenario": each.scenario,
            "variant": each.variant or "-",
            "bricks": str(each.bricks),
            "proven": str(each.proven),
            "statics": each.answer,
            "at s": f"{each.time:.3f}" if each.time is not None else "-",
        }
        for each in said
    ]
    reasons = [line(f"  {each.name}: {each.answer}: {each.reason}") for each in said if each.reason]
    across = [line(f"  {each.name}: stands{touching_text(each.within)}") for each in said if each.within > 0.0]
    blocks: list[Block] = [[table(rows, ("scenario", "variant", "statics"))]]
    blocks += [[line("Not proven to stand", "bold"), *reasons]] if reasons else []
    blocks += [[line("Stable only if gaps count as contact", "bold"), *across]] if across else []
    counts = {answer: sum(each.answer == answer for each in said) for answer in (*ANSWERS.values(), OPEN)}
    sums = ", ".join(f"{count} {answer}" for answer, count in counts.items() if count)
    total = f"{len(said)} variant{'s' * (len(said) != 1)}: {sums}; nothing was played"
    return blocks_text([*blocks, [line(total)]], width, colour)
