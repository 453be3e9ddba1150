"""Rows of contact points whose forces are bounded: joints that pull, or hold sideways without pressure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stability.geometry.rows import Array, Indices
from stability.problem import Contact
from stability.statics.proof import PointLaws


@dataclass(frozen=True, slots=True, eq=False)
class BoundedRows:
    """Limits of the forces of some cones with three rows, in the units of the rows.

    With normal force n and tangential force t, each is limited by n >= least and by |t| <= intercept + slope n for each
    of its borders.
    """

    cones: Indices  # (n,) their numbers among the cones with three rows
    laws: PointLaws  # of these cones
    units: Array  # (n, 2) of normal and tangential forces [N]
    least: Array  # (n,) least normal force
    lift: Array  # (n,) opening speed per sliding speed above which the power of forces is bounded
    borders: tuple[tuple[Indices, Array, Array], ...]  # indices among these cones, their intercepts and slopes

    def project(self, rows: Array, others: Array) -> Array:
        """Return the nearest forces within the limits; `others` holds those of all other rows."""
        nearest = others.copy()
        forces = rows[: 3 * (len(others) // 3)].reshape(-1, 3)[self.cones]
        normal, sideways = forces[:, 0] * self.units[:, 0], forces[:, 1:] * self.units[:, 1:]
        tangential = np.hypot(sideways[:, 0], sideways[:, 1])
        for where, law in self.laws.of_kinds:
            pressed, rubbed = law.project(normal[where], tangential[where])
            share = np.where(
                tangential[where] > 0.0, rubbed / np.where(tangential[where] > 0.0, tangential[where], 1.0), 1.0
            )
            first = 3 * self.cones[where]
            nearest[first] = pressed / self.units[where, 0]
            for part in (1, 2):
                nearest[first + part] = forces[where, part] * share
        return nearest

    def above_least(self, normal: Array) -> Array:
        """Return the normal forces of all cones, with those of these cones above their least one."""
        above = normal.copy()
        above[self.cones] -= self.least
        return above


def bounded_rows(contacts: Sequence[Contact], with_rows: Indices, row_scale: Array) -> BoundedRows | None:
    """Return the limits of the contacts whose law is no cone; None if all are cones.

    `with_rows` holds the numbers of the cones that have three rows, in the order of the rows.
    """
    if all(contact.law.is_cone for contact in contacts):
        return None
    sizes = [len(contact.points_W) * len(contact.normals_W) for contact in contacts]
    is_bounded = np.repeat([not contact.law.is_cone for contact in contacts], sizes)
    cones = np.flatnonzero(is_bounded[with_rows])
    own = [(contact.law, size) for contact, size in zip(contacts, sizes, strict=True) if not contact.law.is_cone]
    laws = PointLaws.of([law for law, _ in own], np.array([size for _, size in own], dtype=np.int64))
    units = np.stack([row_scale[3 * cones], row_scale[3 * cones + 1]], axis=1)
    least, lift, borders = np.zeros(len(cones)), np.zeros(len(cones)), []
    every = np.arange(len(cones))
    for where, law in laws.of_kinds:
        lift[where] = law.lift(1.0) * units[where, 0] / units[where, 1]
        least[where] = law.least_normal / units[where, 0]
        for intercept, slope in law.borders:
            limit = intercept / units[where, 1]
            finite = np.isfinite(limit)
            borders.append((every[where][finite], limit[finite], (slope * units[where, 0] / units[where, 1])[finite]))
    return BoundedRows(cones, laws, units, least, lift, tuple(borders))
