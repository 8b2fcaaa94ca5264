"""Functions that call the kernels of a law by its number, generated from the table of laws.

LLVM cannot inline calls through a table of functions. The kernel of a law is therefore selected by
a chain of comparisons, whose source text is generated here.
"""

from __future__ import annotations

import inspect
from functools import partial
from pathlib import Path
from typing import Any

from cfmpm._jit import beside, depend_on, kernel
from cfmpm.registry.laws import LAWS
from cfmpm.registry.table import load

NUMBERS = {word: number for number, word in enumerate(LAWS)}
"""Number of each law, by which kernels select it."""
_MODULES = {word: load(law.code) for word, law in LAWS.items()}
INTERNAL_VARIABLES: dict[str, tuple[str, ...]] = {
    word: tuple(getattr(module, "INTERNAL_VARIABLES", ())) for word, module in _MODULES.items()
}
"""Names of the internal variables of each law."""
N_CONSTANTS = 2 + max(len(law.constants) for law in LAWS.values())
"""Number of columns of the table of constants: lambda, mu, then the constants of the law."""
_N_INTERNAL = max(map(len, INTERNAL_VARIABLES.values()))


def _columns(word: str) -> dict[str, str]:
    """Return the source text of each constant of a law, by its name."""
    names = ["lam", "mu", *(constant.name for constant in LAWS[word].constants)]
    return {name: f"constants[m, {column}]" for column, name in enumerate(names)}


def _call(word: str, name: str) -> str:
    """Return the source text of a call of a kernel of a law with the arguments that it takes."""
    function = getattr(_MODULES[word], name)
    taken = inspect.signature(getattr(function, "py_func", function)).parameters
    known = _columns(word)
    return f"{word}_{name}({', '.join(known.get(each, each) for each in taken)})"


def _response(word: str) -> list[str]:
    """Return source lines for the response of a law; its state is padded to the longest one."""
    call, n = _call(word, "response"), len(INTERNAL_VARIABLES[word])
    kept = [f"state[{i}]" if i < n else "0.0" for i in range(_N_INTERNAL)]
    padded = f"({', '.join(kept)}{',' * (_N_INTERNAL == 1)})"
    into = "tau, energy, c, state" if n else "tau, energy, c"
    return [f"{into} = {call}", f"return tau, energy, c, {padded}"]


def _across(word: str) -> list[str]:
    has = hasattr(_MODULES[word], "across")
    return [f"return {_call(word, 'across')}" if has else "return 0.0"]


def _chain(name: str, arguments: str, lines: dict[str, list[str]]) -> str:
    """Return the source text of a function that runs the lines of the law with number `law`."""
    text = [f"def {name}(law, constants, m, {arguments}):"]
    *others, last = lines
    for word in others:
        text += [f"    if law == {NUMBERS[word]}:", *(f"        {line}" for line in lines[word])]
    return "\n".join([*text, *(f"    {line}" for line in lines[last]), ""])


_SOURCES = {
    "volumetric": _chain(
        "volumetric", "y", {word: [f"return {_call(word, 'volumetric')}"] for word in LAWS}
    ),
    "response": _chain("response", "H, y, internal, p", {word: _response(word) for word in LAWS}),
    "across": _chain("across", "H, y, tau", {word: _across(word) for word in LAWS}),
}


def _compiled(name: str) -> Any:
    """Compile a generated function; its file is this module, which Numba's cache needs."""
    scope: dict[str, Any] = {"__name__": __name__}
    for word, module in _MODULES.items():
        if hasattr(module, name):
            scope[f"{word}_{name}"] = getattr(module, name)
    exec(compile(_SOURCES[name], __file__, "exec"), scope)
    return kernel(scope[name], inline="always")


# Kernels that call laws of other packages must be compiled again if those change.
_FOREIGN = [
    path
    for module in _MODULES.values()
    if Path(str(module.__file__)).parent != Path(__file__).parent
    for path in beside(Path(str(module.__file__)))
]
if _FOREIGN:
    depend_on(*_SOURCES.values(), *(path.read_text("utf-8") for path in _FOREIGN))
volumetric = _compiled("volumetric")
response = _compiled("response")
across = _compiled("across")


@partial(kernel, inline="always")
def respond(law, constants, m, H, mean, patched, internal, p):
    """Return stress, energy, tangent and new internal variables of one point.

    Parameters
    ----------
    law : int
        Number of the law, from `NUMBERS`.
    constants : (q, c) float
        lambda and mu [MPa], then the constants of the law, for each material.
    m : int
        Row of `constants`.
    H : tuple of four floats
        Displacement gradient F - I as xx, xy, yx, yy; det F > 0.
    mean : float
        Mean of J - 1 over the patch of the point; J - 1 of the point without patches.
    patched : bool
        Whether the tangent omits lambda U'', which couples the points of a patch
        (`patches.coupling`).
    internal : (p, h) float
        Internal variables at the start of the step; read by laws that have some.
    p : int
        Row of `internal`.

    Returns
    -------
    tau : tuple of three floats
        Kirchhoff stress xx, yy, xy [MPa]: tau_mu + lambda U'(mean) J I.
    energy : float
        Stored energy per reference volume [N mm/mm^3]: W_mu + lambda U. With patches, U is
        linearised about the mean. Its sum over the patch is not changed by this, and W I - F^T P
        is the exact derivative of the energy with respect to the reference position.
    c : tuple of six floats
        Spatial tangent xxxx, yyyy, xxyy, xxxy, yyxy, xyxy [MPa] of the Kirchhoff stress, with
        minor symmetries, without the initial stress term: c_ijkl + delta_ik tau_jl is J a_ijkl of
        paper eq 11, misprints corrected.
    state : tuple of floats
        New internal variables, padded by zeros to the largest number that any law has.
    """
    y = H[0] + H[3] + (H[0] * H[3] - H[1] * H[2])
    tau, energy, c, state = response(law, constants, m, H, y, internal, p)
    stored, pressure, bulk = volumetric(law, constants, m, mean)
    energy += stored + pressure * (y - mean)
    pressure *= 1.0 + y
    both = pressure if patched else pressure + bulk * (1.0 + y) * (1.0 + y)
    return (
        (tau[0] + pressure, tau[1] + pressure, tau[2]),
        energy,
        (
            c[0] + both - 2.0 * pressure,
            c[1] + both - 2.0 * pressure,
            c[2] + both,
            c[3],
            c[4],
            c[5] - pressure,
        ),
        state,
    )


@kernel
def stress_across(law, constants, m, H, mean, stress):
    """Return the out-of-plane Cauchy stress of one point in plane strain.

    Parameters
    ----------
    law, constants, m, H, mean
        As in `respond`.
    stress : tuple of three floats
        In-plane Cauchy stress xx, yy, xy [MPa].

    Returns
    -------
    float
        sigma_zz [MPa].
    """
    y = H[0] + H[3] + (H[0] * H[3] - H[1] * H[2])
    J = 1.0 + y
    pressure = volumetric(law, constants, m, mean)[1]
    tau = (J * (stress[0] - pressure), J * (stress[1] - pressure), J * stress[2])
    return pressure + across(law, constants, m, H, y, tau) / J
