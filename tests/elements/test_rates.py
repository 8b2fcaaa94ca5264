"""Convergence rate of each element; a new element needs three lines."""

from __future__ import annotations

import pytest
from exact_fields import gradient_and_round_off, polynomial, rate

from cfmpm.elements.record import find_element
from cfmpm.registry.elements import ELEMENTS


def test_t3():
    assert rate("T3") == pytest.approx(1, abs=0.15)


def test_t6():
    assert rate("T6") == pytest.approx(2, abs=0.15)


def test_t10():
    assert rate("T10") == pytest.approx(3, abs=0.15)


def test_t15():
    assert rate("T15", 8) == pytest.approx(4, abs=0.15)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_polynomials_up_to_the_order_are_exact(element, degree):
    order = find_element(element).order
    error, by_round_off = gradient_and_round_off(element, 4, polynomial(degree))
    assert by_round_off < 1e-9
    if degree <= order:
        assert error <= by_round_off
    else:
        assert error > 1e-5
