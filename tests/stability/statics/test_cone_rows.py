"""Where the forces of contacts are among the rows of a conic program."""

import numpy as np
import pytest
from scipy.sparse import identity

from stability.contact_law import Coulomb
from stability.geometry.rows import Array
from stability.statics.cone_rows import ConeRows, row_units, with_and_without
from stability.statics.conic_program import clarabel_solve

FRICTION = np.array([0.5, 0.0, 2.0, 0.0])


def rows_of_contacts() -> tuple[ConeRows, Array, Array]:
    """Rows, and the forces (4, 3) in them, some of which are in their cones."""
    forces = np.array([[2.0, 0.6, -0.7], [1.5, 0.0, 0.0], [1.0, 3.0, 4.0], [-0.5, 0.0, 0.0]])
    rubbing, smooth = with_and_without(FRICTION)
    rows = ConeRows(len(rubbing), len(smooth))
    scaled = forces / np.where(row_units(FRICTION) > 0.0, row_units(FRICTION), 1.0)
    return rows, rows.joined(scaled[rubbing], scaled[smooth, 0]), forces


def test_cones_with_friction_come_first_and_those_without_have_one_row() -> None:
    rows, values, forces = rows_of_contacts()
    assert len(rows) == len(values) == 8
    assert rows.triples(values)[:, 0].tolist() == forces[[0, 2], 0].tolist()
    assert rows.singles(values).tolist() == forces[[1, 3], 0].tolist()
    assert values[rows.normals].tolist() == forces[[0, 2, 1, 3], 0].tolist()
    assert rows.by_row(np.array([0, 2, 1, 3])).tolist() == [0, 0, 0, 2, 2, 2, 1, 3]


def test_rows_are_in_their_cones_as_the_law_says() -> None:
    rows, values, forces = rows_of_contacts()
    bears = Coulomb(FRICTION).violation(forces[:, 0], np.hypot(forces[:, 1], forces[:, 2])) == 0.0
    assert (rows.spare(values) >= 0.0).tolist() == bears[[0, 2, 1, 3]].tolist() == [True, False, True, False]


def test_the_nearest_rows_are_those_that_a_program_finds() -> None:
    rows, values, _ = rows_of_contacts()
    matrix = identity(len(rows), format="csc")
    program = rows.program(-values, -matrix, np.zeros(len(rows)), curvature=matrix)
    assert rows.project(values) == pytest.approx(clarabel_solve(program, 1e-10).x, abs=1e-7)
    assert rows.spare(rows.project(values)).min() >= -1e-15
    assert rows.project(rows.project(values)) == pytest.approx(rows.project(values), abs=1e-15)


def spare_of(rows: ConeRows, values: Array) -> float:
    """Minus the logarithm of what all forces have to spare."""
    triples, singles = rows.triples(values), rows.singles(values)
    left = triples[:, 0] ** 2 - triples[:, 1] ** 2 - triples[:, 2] ** 2
    return float(-np.log(left).sum() - np.log(singles).sum())


def test_the_barrier_has_the_slopes_of_the_logarithm_of_what_is_to_spare() -> None:
    rows, values = ConeRows(2, 1), np.array([2.0, 0.5, -0.7, 1.0, 0.3, 0.1, 0.4])
    gradient, inverse = rows.barrier(values)
    step = 1e-5 * np.identity(len(rows))
    slopes = [(spare_of(rows, values + each) - spare_of(rows, values - each)) / 2e-5 for each in step]
    assert gradient == pytest.approx(slopes, rel=1e-8)
    curved = np.array([(rows.barrier(values + each)[0] - rows.barrier(values - each)[0]) / 2e-5 for each in step])
    for cone in range(2):
        own = slice(3 * cone, 3 * cone + 3)
        block = inverse[9 * cone : 9 * cone + 9].reshape(3, 3)
        assert block @ curved[own, own] == pytest.approx(np.identity(3), abs=1e-8)
    assert inverse[-1] * curved[-1, -1] == pytest.approx(1.0, rel=1e-8)
