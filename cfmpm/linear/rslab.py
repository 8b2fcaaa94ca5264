"""L D L^T of the Rust library rslab."""

from __future__ import annotations

from importlib import import_module
from typing import ClassVar

from scipy.sparse import csr_array

from cfmpm.linear.engine import TOLERANCE, Floats, NotPositiveDefiniteError


class Rslab:
    """L D L^T of the Rust library rslab, on one thread; it returns the inertia."""

    direct: ClassVar[bool] = True

    def __init__(self, K: csr_array, modes: Floats | None) -> None:
        # Minimum fill takes a quarter of the time of nested dissection, with most of its benefit.
        rslab = import_module("rslab")
        self._symbolic = rslab.analyze(K, path="ldlt", threads=1, ordering="amf")

    def factor(self, K: csr_array) -> None:
        try:
            self._factor = self._symbolic.factor(K)
        except RuntimeError as failure:
            raise NotPositiveDefiniteError(str(failure)) from failure
        _, negative, zero = self._factor.inertia
        if negative or zero:
            raise NotPositiveDefiniteError(f"{negative} pivots are negative and {zero} are zero")

    def solve(self, b: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, tuple[float, ...]]:
        return self._factor.solve(b), ()
