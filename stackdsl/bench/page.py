"""A bench as a page of Markdown, beside its data: what was run, with what, the table, the picture, every case."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from stackdsl.bench.conduct import Bench
from stackdsl.bench.entrants import NO_STEPS
from stackdsl.bench.plot import FILES
from stackdsl.bench.points import COMPARED_WITH, pace_of
from stackdsl.bench.scoring import Score, numerical_reason
from stackdsl.bench.table import closing_line, not_taken, number, point_rows, run_row
from stackdsl.report.blocks import Row
from stackdsl.trace import NUMERICAL_COLLAPSE

READING = """\
One row is one system at one time step: its own, times or divided by a number; iterations and all else stay as they
are.

- `wrong`: verdicts (stands or falls) other than what is known, out of those where it is: from the scenarios'
  `truth`, from exact statics, or else from the two finest runs of `tuned`, or of `stock`, if they agree. Such a
  reference counts as right.
- `numerical`: collapses that statics disprove, or that the next finer time step of the same system does not show.
- Errors are the largest over the scenarios, and `-` where nothing is known to compare with. `levels`: how many
  levels too early or too late it falls; where it should stand, how many were missing when it fell. `creep`: how far
  anything moves in a structure that should stand still, also by falling; and in one that should fall, how far before
  the brick comes with which it does. The other three are those of runs with the
  right verdict, from truths and from that reference, which has no distance from itself. `mm`: lengths, such as how
  far away a fall lands, or how far what is hit goes. `deg`: angles, such as which way it falls. `s`: when it
  falls, by more than the 10 ms between two looks at a run.
- `energy`: the largest gain after the last action, as a share of what there was then, heights counted from the ground.
- `wall s`: the time to the answer. A collapse is followed, by every system, only where something hits the structure
  or a truth asks what becomes of it. `wall s / sim. s`, the pace, is the geometric mean over the scenarios that all
  rows have finished, but for rows that do not take them; a row that does not take all of these has none. `x exact`:
  the pace in times of that of `exact` at its own time step, over the scenarios that both have finished.
- `steps`, `solves`: engine steps, and proofs and their answers, summed. `MiB`: the most memory that a run took.
- `update ms`, `worst ms`: what one update of the extension takes, the wait of whoever plays with bricks while it
  watches them: the median over the scenarios of the median update of each, and the worst update of any. `-` where no
  extension takes part; a bare engine is felt by its steps alone.
- `front`: the errors in which no row is both faster and nearer; `seconds` is that of the column `s`.

What takes no engine step is played at one time step and copied to the others. `cra` and `rbe` (compas_cra) tell
whether it stands after each placement, and nothing of motion: what they do not take is listed as not taken, and
their time ends where they say that it falls."""

KEPT = ("system", "verdict", "levels", "creep mm", "mm", "deg", "s")  # columns of a run that are told of each case
COSTS = ("wall s", "steps", "solves", "MiB", "update ms", "worst ms")  # and these


def bench_page(bench: Bench, drawn: bool) -> str:
    """The page; the picture is beside it if it was drawn."""
    return "\n".join(_lines(bench, drawn)) + "\n"


def _lines(bench: Bench, drawn: bool) -> Iterator[str]:
    yield "# Speed against error"
    yield ""
    yield "Written by `stackdsl bench`; see `make bench`. Machines differ and are shared: quote ratios, not seconds."
    yield ""
    yield f"{closing_line(bench)}. Versions: {', '.join(f'{name} {found}' for name, found in bench.versions.items())}."
    yield ""
    if drawn:
        yield f"![Speed against error, one panel a kind of error]({FILES[1]})"
        yield ""
    yield READING
    yield ""
    yield from markdown_table(point_rows(bench.points))
    yield from _listed("Not taken", not_taken(bench.scores))
    numerical = [score for score in bench.scores if score.verdict == NUMERICAL_COLLAPSE]
    yield from _listed("Numerical collapses", [f"{s.record.name}: {numerical_reason(s)}" for s in numerical])
    yield from _cases(bench)


def _listed(title: str, told: Sequence[str]) -> Iterator[str]:
    if told:
        yield ""
        yield f"## {title}"
        yield ""
        yield from (f"- {each}" for each in told)


def _cases(bench: Bench) -> Iterator[str]:
    """Each case at the systems' own time steps."""
    own = [score for score in bench.scores if score.record.factor in (1.0, NO_STEPS) and score.record.taken]
    if own:
        yield ""
        yield "## Case by case, at each system's own time step"
        yield ""
        yield f"`x {COMPARED_WITH}` is the wall time for a simulated second, in times of what `{COMPARED_WITH}` takes."
    for case, group in groupby(own, key=lambda score: score.record.case):
        scores = list(group)
        answer = bench.answers[case]
        known = "" if answer is None else f": {'stands' if answer.stands else 'falls'}, {answer.source}"
        yield ""
        yield f"### {case}{known}"
        yield ""
        fastest = next((pace_of(score.record) for score in scores if score.record.system == COMPARED_WITH), None)
        yield from markdown_table([_case_row(score, fastest) for score in scores])


def _case_row(score: Score, compared_with: float | None) -> Row:
    """One run, with its pace in times of another."""
    row = run_row(score)
    told = {key: row[key] for key in (*KEPT, *COSTS)}
    told["verdict"] += ", wrong" if score.wrong else ""
    fell = score.record.seen("collapse level")
    pace = pace_of(score.record) if score.record.done else None
    told[f"x {COMPARED_WITH}"] = number(pace / compared_with if pace and compared_with else None)
    told["levels"] = told["levels"] if fell is None else f"{told['levels']} (falls at {number(fell)})"
    return told


def markdown_table(rows: Sequence[Row]) -> Iterator[str]:
    """Rows with the same columns."""
    if not rows:
        return
    yield f"| {' | '.join(rows[0])} |"
    yield f"|{'|'.join('---' for _ in rows[0])}|"
    yield from (f"| {' | '.join(cell.replace('|', '&#124;') for cell in row.values())} |" for row in rows)
