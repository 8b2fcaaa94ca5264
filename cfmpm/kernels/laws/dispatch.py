"""From the number of a law to its kernels, made from the table of laws.

Numba has no table of functions that LLVM could look into: what picks the kernel of a law is a chain
of comparisons, whose source text is made here.
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
"""The number of each law, which kernels know it by."""
_MODULES = {word: load(law.code) for word, law in LAWS.items()}
INTERNAL_VARIABLES: dict[str, tuple[str, ...]] = {
    word: tuple(getattr(module, "INTERNAL_VARIABLES", ())) for word, module in _MODULES.items()
}
"""The variables that each law keeps of a point."""
N_CONSTANTS = 2 + max(len(law.constants) for law in LAWS.values())
"""Columns of the table of constants: lambda, mu and those of the laws, each from the third on."""
_N_INTERNAL = max(map(len, INTERNAL_VARIABLES.values()))


def _columns(word: str) -> dict[str, str]:
    """What the kernels of a law take for its constants, by their names."""
    names = ["lam", "mu", *(constant.name for constant in LAWS[word].constants)]
    return {name: f"constants[m, {column}]" for column, name in enumerate(names)}


def _call(word: str, name: str) -> str:
    """A kernel of a law with what it takes, as source text."""
    function = getattr(_MODULES[word], name)
    taken = inspect.signature(getattr(function, "py_func", function)).parameters
    known = _columns(word)
    return f"{word}_{name}({', '.join(known.get(each, each) for each in taken)})"


def _response(word: str) -> list[str]:
    """Lines that return the response of a law, with as many state variables as any has."""
    call, n = _call(word, "response"), len(INTERNAL_VARIABLES[word])
    kept = [f"state[{i}]" if i < n else "0.0" for i in range(_N_INTERNAL)]
    padded = f"({', '.join(kept)}{',' * (_N_INTERNAL == 1)})"
    into = "tau, energy, c, state" if n else "tau, energy, c"
    return [f"{into} = {call}", f"return tau, energy, c, {padded}"]


def _across(word: str) -> list[str]:
    has = hasattr(_MODULES[word], "across")
    return [f"return {_call(word, 'across')}" if has else "return 0.0"]


def _chain(name: str, arguments: str, lines: dict[str, list[str]]) -> str:
    """A function that has the lines of the law whose number it is called with."""
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
    """Compile one of the chains, as a function of this file: Numba keeps the code by that."""
    scope: dict[str, Any] = {"__name__": __name__}
    for word, module in _MODULES.items():
        if hasattr(module, name):
            scope[f"{word}_{name}"] = getattr(module, name)
    exec(compile(_SOURCES[name], __file__, "exec"), scope)
    return kernel(scope[name], inline="always")


# What calls laws of other packages is compiled anew where these change.
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
    """Return stress, energy, tangent and new state of one point.

    Parameters
    ----------
    law : int
        One of `NUMBERS`.
    constants : (q, c) float
        lambda, mu and the constants of the laws, each from the third column on.
    m : int
        Row of `constants`.
    H : tuple of four floats
        xx, xy, yx, yy of the displacement gradient F - I; det F > 0.
    mean : float
        Mean of J - 1 over the point's patch; the point's own without patches.
    patched : bool
        Whether the tangent leaves out lambda U'', which then couples the points of a patch.
    internal : (p, h) float
        Internal variables at the start of the step; read by laws that have some.
    p : int
        Row of `internal`.

    Returns
    -------
    tau : tuple of three floats
        Kirchhoff stress xx, yy, xy [MPa]; tau_mu + lambda U'(mean) J I.
    energy : float
        Stored energy per reference volume [MPa], W_mu + lambda U; with patches U is continued
        linearly from the mean, which adds up to the same over the patch and makes W I - F^T P
        the exact derivative with respect to the reference position.
    c : tuple of six floats
        Spatial tangent xxxx, yyyy, xxyy, xxxy, yyxy, xyxy [MPa] of the Kirchhoff stress, with
        minor symmetries; the stress term delta_ik tau_jl stands apart: c_ijkl + delta_ik tau_jl
        is J a_ijkl of paper eq 11 with misprints put right.
    state : tuple of floats
        New row of internal variables, as long as the longest of any law; zero beyond the own.
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
    """Return sigma_zz of one point in plane strain [MPa].

    Parameters
    ----------
    law, constants, m, H, mean
        As in `respond`.
    stress : tuple of three floats
        Cauchy stress xx, yy, xy [MPa].
    """
    y = H[0] + H[3] + (H[0] * H[3] - H[1] * H[2])
    J = 1.0 + y
    pressure = volumetric(law, constants, m, mean)[1]
    tau = (J * (stress[0] - pressure), J * (stress[1] - pressure), J * stress[2])
    return pressure + across(law, constants, m, H, y, tau) / J
