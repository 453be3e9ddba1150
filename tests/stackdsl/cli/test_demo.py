"""`stackdsl demo`: what a new user sees first."""

from pathlib import Path

from stackdsl.cli.demo import PREFIX
from tests.command_line import Stackdsl
from tests.engines_at_hand import needs_pybullet


@needs_pybullet
def test_the_demo_shows_proof_and_fall_and_writes_nothing_here(stackdsl: Stackdsl, tmp_path: Path) -> None:
    elsewhere = tmp_path.parent / "elsewhere"
    elsewhere.mkdir(exist_ok=True)
    done = stackdsl("demo", TMPDIR=str(elsewhere))
    assert done.code == 0
    assert "L9.1, proven to stand" in done.out  # 9 x 12 mm is less than a plank, 117.6 mm
    assert "L2.1 to L10.1 (9 bricks) tip over L1.1" in done.out
    assert list(tmp_path.iterdir()) == []
    (page,) = elsewhere.glob(f"{PREFIX}*.html")
    assert str(page) in done.out
    assert "demo[exact]" in page.read_text(encoding="utf-8")
