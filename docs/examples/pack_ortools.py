"""Lay cartons in layers with the CP-SAT solver of OR-Tools, and find the first placement that loses its support.

Run: pip install ortools; python docs/examples/pack_ortools.py
"""

from ortools.sat.python import cp_model

from stackdsl.packing import PackedBox, check

LENGTH, WIDTH = 1200, 800  # [mm] of the deck
CARTONS = {"a": (600, 400, 300, 12), "b": (400, 300, 300, 7), "c": (500, 300, 300, 9)}  # sides [mm] and mass [kg]


def layer(wanted: list[str]) -> list[tuple[str, int, int, int, int]]:
    """Return name, x, y, and sides along x and y of cartons on one layer, pushed towards the corner [mm]."""
    model = cp_model.CpModel()
    places, spans_x, spans_y = [], [], []
    for number, name in enumerate(wanted):
        length, width, *_ = CARTONS[name]
        turned = model.new_bool_var(f"turned-{number}")
        side_x = model.new_int_var(min(length, width), max(length, width), f"side-x-{number}")
        side_y = model.new_int_var(min(length, width), max(length, width), f"side-y-{number}")
        model.add(side_x == length + (width - length) * turned)
        model.add(side_y == width + (length - width) * turned)
        x, y = model.new_int_var(0, LENGTH, f"x-{number}"), model.new_int_var(0, WIDTH, f"y-{number}")
        end_x, end_y = model.new_int_var(0, LENGTH, f"to-x-{number}"), model.new_int_var(0, WIDTH, f"to-y-{number}")
        spans_x.append(model.new_interval_var(x, side_x, end_x, f"along-x-{number}"))
        spans_y.append(model.new_interval_var(y, side_y, end_y, f"along-y-{number}"))
        places.append((name, x, y, side_x, side_y))
    model.add_no_overlap_2d(spans_x, spans_y)
    model.minimize(sum(x + y for _, x, y, *_ in places))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    return [(name, *(solver.value(each) for each in values)) for name, *values in places]


def packed(layers: list[list[str]]) -> list[PackedBox]:
    """Return the cartons of all layers, from the bottom up. All cartons are of one height."""
    boxes = []
    for level, wanted in enumerate(layers):
        for number, (name, x, y, side_x, side_y) in enumerate(layer(wanted)):
            *_, height, mass = CARTONS[name]
            boxes.append(PackedBox(f"{name}{level}-{number}", (x, y, level * height), (side_x, side_y, height), mass))
    return boxes


# CP-SAT knows nothing of support: a layer of fewer cartons below a full one leaves a carton over a hole.
print(check(packed([["a"] * 4, ["a"] * 4]), deck="EUR", unit="mm", friction=0.4))
print(check(packed([["b"] * 3, ["c"] * 4]), deck="EUR", unit="mm", friction=0.4))
