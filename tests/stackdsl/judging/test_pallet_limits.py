"""Limits of a load on its pallet: overhang, weight and centre of mass have closed forms, wherever the pallet stands."""

import pytest

from stackdsl.api.cases import loads
from stackdsl.api.run import play
from tests.scenes import mistakes_of

# Three cartons of 12 kg and one of 24 kg, by x, y, z of their centres on the deck [mm] and their sides.
CARTONS = (
    ("a", (-320, -200, 150), (600, 400, 300), 12),
    ("b", (300, -200, 150), (600, 400, 300), 12),
    ("c", (-300, 210, 150), (600, 400, 300), 12),
    ("d", (-300, -200, 350), (600, 400, 100), 24),
)


def scene(x: float = 0.0, y: float = 0.0, turned: bool = False, height: float = 144.0, more: str = "") -> str:
    """The cartons on a deck whose middle is at x, y [mm]; turned by 90 deg if wanted."""
    rotate = ", rotate: [0 deg, 0 deg, 90 deg]" if turned else ""
    lines = [f"{{name: deck, at: [{x} mm, {y} mm, {height / 2} mm]{rotate},"]
    lines[0] += f" brick: {{pallet: {{size: EUR, height: {height} mm}}, mass: 25 kg}}}}"
    for name, (a, b, c), size, mass in CARTONS:
        px, py = (x - b, y + a) if turned else (x + a, y + b)
        lines.append(
            f"{{name: {name}, at: [{px} mm, {py} mm, {c + height} mm]{rotate},"
            f" brick: {{size: [{size[0]} mm, {size[1]} mm, {size[2]} mm], mass: {mass} kg}}}}"
        )
    steps = "".join(f"      - {line}\n" for line in lines)
    return f"scenario: s\nfriction: 0.4\n{more}build:\n  - bricks:\n{steps}"


def judged(text: str, *claims: str) -> list[tuple[bool, str]]:
    (case,) = loads(f"{text}expect:\n" + "".join(f"  - {claim}\n" for claim in claims))
    return [(outcome.passed, outcome.measured) for outcome in play(case).outcomes]


@pytest.mark.parametrize("place", [(0.0, 0.0, False), (600.0, 400.0, False), (-50.0, 17.0, True)])
def test_limits_are_met_and_missed_at_their_closed_forms_wherever_the_pallet_stands(
    place: tuple[float, float, bool],
) -> None:
    #   x: (-320 + 300 - 300 - 2 * 300) / 5 = -184, y: (-200 - 200 + 210 - 2 * 200) / 5 = -118, z: (450 + 700) / 5 = 230
    found = judged(
        scene(*place),
        "overhang: <= 20 mm",
        "overhang: < 20 mm",
        "weight: <= 85 kg",
        "weight: < 85 kg",
        "weight: {is: <= 60 kg, without: [deck]}",
        "centre_of_mass: {offset: <= 218.6 mm, height: 374 mm ± 0.001 mm}",
        "centre_of_mass: {offset: <= 218.5 mm}",
    )
    assert [passed for passed, _ in found] == [True, False, True, False, True, True, False]
    assert found[0][1] == "20 mm by a towards -x"
    assert found[5][1] == "offset 218.6 mm (-184 mm along, -118 mm across), height 374 mm"


def test_a_weight_as_a_force_counts_the_gravity_of_the_scene() -> None:
    on_earth, on_the_moon = scene(), scene(more="world: {gravity: 1.62 m/s2}\n")
    assert judged(on_earth, "weight: <= 833.9 N", "weight: <= 833.8 N") == [(True, "833.85 N"), (False, "833.85 N")]
    assert judged(on_the_moon, "weight: 137.7 N ± 0.1 N")[0][0]


def test_the_height_of_the_centre_of_mass_counts_from_below_the_pallet() -> None:
    assert judged(scene(height=100), "centre_of_mass: {height: 330 mm ± 0.001 mm}")[0][0]


def test_a_load_inside_its_deck_has_no_overhang() -> None:
    text = scene().replace("at: [-320.0 mm", "at: [-300.0 mm").replace("210.0 mm", "200.0 mm")
    assert judged(text, "overhang: <= 0 mm")[0] == (True, "0 mm, 0 mm inside")


def test_without_a_pallet_its_limits_are_refused_with_the_remedy() -> None:
    (mistake,) = mistakes_of("- column: {levels: 2}", "expect:\n  - overhang: <= 20 mm\n")
    assert mistake.message == "there is no brick 'deck'"
    assert "build the pallet, such as with `deck: {size: EUR, surface: closed}`" in mistake.hint


def test_a_carton_that_falls_counts_where_it_was_placed() -> None:
    text = (
        scene()
        .replace("at: [300 mm, -200", "at: [620.0 mm, -200")
        .replace("at: [300.0 mm, -200", "at: [620.0 mm, -200")
    )
    assert judged(text, "overhang: 320 mm ± 0.001 mm", "falls: {bricks: [b]}") == [
        (True, "320 mm by b towards +x"),
        (True, "b fell"),
    ]
