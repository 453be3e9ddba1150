"""The warm-up imports every module that a verdict may need, before the first save."""

import subprocess
import sys
from textwrap import dedent

# Fifty levels of pairs: with a step of 1 mm they stand by each other's weight, with 6 mm they fall.
PROGRAM = dedent(
    """
    import sys
    import stackdsl.cli.run
    from stackdsl.checking.cases import cases_of
    from stackdsl.language.yaml.source import parse
    from stackdsl.viewing.live import preview
    from stackdsl.viewing.live import warm_up

    TOWER = '''
    scenario: tower
    build:
      - four_stack: {{levels: {levels}, step: {step}, spacing: 43 mm}}
        every: 1 s
    systems: [exact]
    expect: [{{stands: all}}]
    '''

    def seen(text):
        cases, mistakes = cases_of(parse(text, "scene.yaml"))
        assert not mistakes, mistakes
        return preview(cases[0])

    seen(TOWER.format(levels=2, step="0.5 mm"))
    if sys.argv[1:] == ["warm"]:
        warm_up()
    before = set(sys.modules)
    assert "proven to stand" in seen(TOWER.format(levels=50, step="1 mm"))
    assert "proven to fall" in seen(TOWER.format(levels=50, step="6 mm"))
    print(*sorted({name.split(".")[0] for name in set(sys.modules) - before}))
    """
)


def imported_by_a_save(*how: str) -> list[str]:
    done = subprocess.run([sys.executable, "-c", PROGRAM, *how], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_what_a_verdict_may_need_is_imported_before_the_first_save() -> None:
    assert imported_by_a_save("warm") == []
