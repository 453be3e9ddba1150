"""Which way what falls goes, in words."""

from math import degrees

from stability.statics.solvers.fall_side import FallSide
from stackdsl.wording import mm

AXES = {0: "+x", 90: "+y", 180: "-x", 270: "-y"}  # by bearing [deg]
ROUNDED = 0.05  # [deg] a bearing this near to an axis is along it


def side_text(side: FallSide) -> str:
    """`towards +x, its weight 1.2 mm beyond the edge`; empty where there is neither."""
    told = [f"towards {bearing_text(side.bearing)}"] if side.bearing is not None else []
    told += [f"its weight {mm(side.overhang, 3)} beyond the edge"] if side.overhang is not None else []
    return ", ".join(told)


def bearing_text(bearing: float) -> str:
    """A bearing [rad] as the axis that it is along, or in degrees from +x towards +y."""
    angle = degrees(bearing) % 360.0
    nearest = 90 * round(angle / 90.0)
    return AXES[nearest % 360] if abs(angle - nearest) <= ROUNDED else f"{angle:.1f} deg"
