"""What is lost of a residual because coordinates far from the origin are rounded."""

from dataclasses import replace

from stability.statics.facts import Problem, Tolerances

LOST_DIGITS = 1e-15  # share of a coordinate, a few times the error of one rounding


def rounded(problem: Problem, tolerances: Tolerances) -> Tolerances:
    """Tolerances, with what is lost where the bricks of a problem are."""
    furthest = max((abs(part) for p in problem.bricks.values() for part in p.pose.position_W), default=0.0)
    smallest = min((p.brick.shape.length for p in problem.bricks.values()), default=1.0)
    return replace(tolerances, residual=tolerances.residual + LOST_DIGITS * furthest / smallest)
