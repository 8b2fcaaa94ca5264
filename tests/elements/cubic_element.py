"""An element of order 3 as another package would add it: the rule and the domains of T10."""

from __future__ import annotations

from dataclasses import replace

from cfmpm.elements.t10 import T10
from cfmpm.registry.elements import ElementEntry

CUBIC = replace(T10)
ENTRY = ElementEntry("6 points", "cubic_element:CUBIC")

# The same without the polygons that its points represent, which growth needs.
CUBIC_STATIONARY = replace(CUBIC, domains=None)
STATIONARY_ENTRY = ElementEntry("6 points", "cubic_element:CUBIC_STATIONARY")
