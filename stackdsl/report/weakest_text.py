"""The weakest spot of a structure, in the same words wherever it is told, and as JSON."""

from collections.abc import Mapping
from math import degrees
from typing import Any

from stability.statics.margins.weakest import Weakest


def weakest_text(weakest: Weakest) -> str:
    """`weakest: L2.1; from 0.258 g towards 0 deg on, L2.1, L3.1 tip over L1.1`."""
    bearing = f"{round(degrees(weakest.bearing), 1) % 360.0:.4g}"
    return f"weakest: {weakest.brick}; from {weakest.acceleration:.4g} g towards {bearing} deg on, {weakest.gives_way}"


def weakest_json(weakest: Weakest) -> Mapping[str, Any]:
    """The same by key, with every brick that begins to move."""
    return {
        "brick": weakest.brick,
        "bricks": list(weakest.bricks),
        "survives_g": float(f"{weakest.acceleration:.6g}"),
        "fails_g": float(f"{weakest.fails:.6g}"),
        "bearing_deg": float(f"{degrees(weakest.bearing):.6g}"),
        "gives_way": weakest.gives_way,
    }
