"""Limits of the decision which tips grow: interfaces, round-off, ties, closed faces."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from structured import rectangle

from cfmpm.body.grid import Floats, Grid, build_grid
from cfmpm.ending import RunEnded
from cfmpm.fracture import growth
from cfmpm.fracture.growth import Decision
from cfmpm.scene.growth import Growth

# An inner crack from x = 2/8 to 5/8 at half the height.
GRID = build_grid(rectangle(8, 6, crack=(3, 2, 5)), "T3")
START, END = "crack_1_start", "crack_1_end"


def values(g: Any, k_1: Any = (1.0, 1.0), k_2: Any = (0.0, 0.0), **more: Any) -> dict[str, Floats]:
    radius = {"G_radius": np.array(g)[:, None], "J_radius": np.array(g)[:, None]}
    found = {"G": g, "cf_norm": g, "K_I": k_1, "K_II": k_2} | radius | more
    found.setdefault("cf_x", (-1.0, 1.0))
    found.setdefault("cf_y", (0.0, 0.0))
    return {name: np.array(value, float) for name, value in found.items()}


def decide(g: Any, config: dict[str, Any] | None = None, **more: Any) -> Decision:
    return growth.decide(GRID, values(g), [1.0], Growth(**(config or {})), **more)


def halves(below: int, above: int) -> Grid:
    """The grid with different materials on both sides of the line of the crack."""
    centre = GRID.nodes[GRID.triangles].mean(axis=1)
    regions = np.where(centre[:, 1] > 0.5, above, below)
    return replace(GRID, regions=regions, region_names=("body", "other"))


@pytest.mark.parametrize(("below", "above"), [(0, 1), (1, 0)])
@pytest.mark.parametrize("g_c", [[1.0, 4.0], [4.0, 1.0]])
def test_along_a_border_the_weaker_material_counts(
    g_c: list[float], below: int, above: int
) -> None:
    grid, config = halves(below, above), Growth(control="crack")
    along = growth.decide(grid, values([0.1, 0.25]), g_c, config)
    assert along.load_factor == pytest.approx(math.sqrt(1.0 / 0.25))
    assert set(along.running) == {END}
    load = growth.decide(grid, values([1.1, 0.9]), g_c, Growth())
    assert set(load.running) == {START}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_off_a_border_the_material_that_it_kinks_into_counts(sign: float) -> None:
    """A force that points up is compared with g_c above, one that points down with that below."""
    config = Growth(control="crack", direction="cf", criterion="cf_norm")
    aside = values([0.01, 0.25], cf_y=(0.0, 0.3 * sign))
    found = growth.decide(halves(0, 1), aside, [1.0, 4.0], config)
    assert found.load_factor == pytest.approx(math.sqrt((4.0 if sign > 0.0 else 1.0) / 0.25))


class TestWhatIsLeftOfABodyThatCameApart:
    """A driving force below 1e-18 of that of the last step is round-off.

    G is stored at load factor one, where it can be small compared with the critical
    value g_c / factor^2.
    """

    @pytest.mark.parametrize("load", [0.01, 1.0, 50.0])
    def test_nothing_but_round_off_drives_no_tip(self, load: float) -> None:
        last = Decision(load, {})
        left = decide([0.9e-18 / load**2, 0.5e-18 / load**2], {"control": "crack"}, last=last)
        assert left.load_factor == math.inf
        assert left.running == {}
        with pytest.raises(RunEnded, match="no tip meets the criterion at any load") as end:
            growth.check_end(Growth(control="crack"), left, GRID.tips, 3, lengths={})
        assert end.value.ending.status == "stopped"

    @pytest.mark.parametrize("load", [0.01, 1.0, 50.0])
    def test_a_little_more_than_that_is_no_round_off(self, load: float) -> None:
        driving = 1.1e-18 / load**2
        found = decide([driving, 0.0], {"control": "crack"}, last=Decision(load, {}))
        assert found.load_factor == pytest.approx(driving**-0.5)
        assert set(found.running) == {START}

    def test_a_small_load_at_the_start_is_no_round_off(self) -> None:
        """There is no scale before the first step: small values are valid."""
        assert decide([1e-20, 0.0], {"control": "crack"}).load_factor == pytest.approx(1e10)

    def test_under_load_control_the_load_is_what_it_is(self) -> None:
        assert decide([1e-20, 0.0], last=Decision(1.0, {})).load_factor == 1.0


@pytest.mark.parametrize(("other", "runs"), [(0.985, True), (0.975, False)])
def test_tips_within_the_errors_of_both_run_with_the_first(other: float, runs: bool) -> None:
    """J and G differ by 1 % at each tip."""
    g = [0.25 * other, 0.25]
    state = values(g, J_radius=0.99 * np.array(g)[:, None])
    found = growth.decide(GRID, state, [1.0], Growth(control="crack"))
    assert (START in found.running) == (START in found.tied) == runs
    assert END in found.running
    assert found.load_factor == pytest.approx(2.0)
    alone = growth.decide(GRID, state, [1.0], Growth(control="crack", tips="largest"))
    assert set(alone.running) == {END}


def test_forces_go_with_the_square_of_the_load() -> None:
    """Solved at half the load of the step: the driving force is a quarter."""
    assert set(decide([0.26, 0.24], scale=2.0).running) == {START}
    assert set(decide([1.3, 4.1], scale=0.5).running) == {END}


def test_a_tip_just_at_its_toughness_runs() -> None:
    assert set(decide([1.0, 1.0 - 1e-15]).running) == {START}


class TestClosedTips:
    """A closed tip with more compression than shear has no direction and no driving force."""

    @pytest.mark.parametrize("shear", [0.0, 1.0, -1.0])
    def test_up_to_the_limit_nothing_drives_it(self, shear: float) -> None:
        for k_1, runs in ((-abs(shear) * (1 + 1e-9) - 1e-9, False), (-abs(shear), False)):
            found = values([2.0, 9.0], k_1=(1.0, k_1), k_2=(0.0, shear))
            at_load = growth.decide(GRID, found, [1.0], Growth())
            assert (END in at_load.running) == runs
            control = growth.decide(GRID, found, [1.0], Growth(control="crack"))
            assert control.load_factor == pytest.approx(math.sqrt(0.5))
            assert set(control.running) == {START}

    @pytest.mark.parametrize("shear", [1.0, -1.0])
    def test_beyond_it_shear_drives_it_though_k_1_is_negative(self, shear: float) -> None:
        found = values([0.5, 9.0], k_1=(1.0, -0.99), k_2=(0.0, shear))
        assert set(growth.decide(GRID, found, [1.0], Growth()).running) == {END}

    @pytest.mark.parametrize("criterion", ["cf_norm", "energy_release_rate"])
    def test_nothing_drives_it_by_the_configurational_force_either(self, criterion: str) -> None:
        """The configurational force has a direction at any tip."""
        config = Growth(criterion=criterion, direction="cf")
        found = values([2.0, 9.0], k_1=(1.0, -1.0), k_2=(0.0, 0.5))
        assert set(growth.decide(GRID, found, [1.0], config).running) == {START}

    def test_nor_one_whose_criterion_has_no_direction(self) -> None:
        """A configurational force of zero has no direction."""
        config = Growth(criterion="energy_release_rate", direction="cf")
        found = values([2.0, 9.0], cf_x=(-1.0, 0.0))
        with np.errstate(invalid="ignore"):
            assert set(growth.decide(GRID, found, [1.0], config).running) == {START}


def test_what_drives_a_kink_counts_and_g_where_it_is_not_known() -> None:
    """At the interface of two materials there is no K, and therefore no G_kink."""
    found = values([0.9, 1.2], G_kink=(1.1, np.nan))
    assert set(growth.decide(GRID, found, [1.0], Growth()).running) == {START, END}
    found = values([1.2, 0.8], G_kink=(0.9, np.nan))
    assert growth.decide(GRID, found, [1.0], Growth()).running == {}
    force = Growth(criterion="cf_norm", direction="cf")
    assert set(growth.decide(GRID, found, [1.0], force).running) == {START}


def to(angle: float) -> Floats:
    """Unit vector at an angle [deg]."""
    return np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])


def bearing(vector: Floats) -> float:
    """Angle of a vector [deg]."""
    return math.degrees(math.atan2(vector[1], vector[0]))


class TestSecondOrder:
    """Segments are turned further by half of the last turn of the path, at most 5 degrees."""

    @pytest.mark.parametrize(
        ("turn", "on"), [(8.0, 4.0), (-8.0, -4.0), (30.0, 5.0), (-30.0, -5.0), (-90.0, -5.0)]
    )
    def test_the_turn_goes_on_to_either_side(self, turn: float, on: float) -> None:
        assert bearing(growth.secant(to(20.0), to(20.0 + turn))) == pytest.approx(20.0 + turn + on)

    def run(self, order: int, **more: Any) -> Decision:
        config = Growth(order=order, direction="cf", criterion="cf_norm")
        found = values([0.5, 2.0], cf_x=(-1.0, to(6.0)[0]), cf_y=(0.0, to(6.0)[1]))
        last = Decision(1.0, {END: to(0.0)}, {START: to(180.0), END: to(0.0)})
        return growth.decide(GRID, found, [1.0], config, last, **more)

    def test_by_order_and_with_the_tangent_kept(self) -> None:
        first, second = self.run(1), self.run(2)
        assert bearing(first.running[END]) == pytest.approx(6.0)
        assert bearing(second.running[END]) == pytest.approx(9.0)
        for found in (first, second):
            assert bearing(found.tangents[END]) == pytest.approx(6.0)

    def test_a_tip_that_rests_keeps_the_tangent_with_which_it_came(self) -> None:
        np.testing.assert_array_equal(self.run(2).tangents[START], to(180.0))

    def test_a_tip_whose_domain_tells_no_direction_goes_straight_on(self) -> None:
        """Neither the force nor the last turn of the path changes its direction."""
        found = self.run(2, unresolved={END})
        np.testing.assert_allclose(found.running[END], to(0.0), atol=1e-15)
        last = Decision(1.0, {}, {END: to(-8.0)})
        config = Growth(order=2, direction="cf", criterion="cf_norm")
        bent = growth.decide(GRID, values([0.5, 2.0]), [1.0], config, last, unresolved={END})
        np.testing.assert_allclose(bent.running[END], to(0.0), atol=1e-15)


def test_where_no_tip_is_left_the_load_is_unknown_but_under_load_control() -> None:
    none = replace(GRID, tips=())
    assert growth.decide(none, {}, [1.0], Growth(), load_factor=0.5).load_factor == 0.5
    control = growth.decide(none, {}, [1.0], Growth(control="crack"), load_factor=0.5)
    assert math.isnan(control.load_factor)


def test_a_load_that_rises_is_awaited() -> None:
    nothing = Decision(1.0, {})
    for config in (None, Growth()):
        growth.check_end(config, nothing, GRID.tips, 1, last_level=False, lengths={})
        with pytest.raises(RunEnded):
            growth.check_end(config, nothing, GRID.tips, 1, lengths={})
