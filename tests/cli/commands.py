"""Calls of the command line for tests."""

from __future__ import annotations

import subprocess
import sys

from typer.testing import CliRunner, Result

from cfmpm.cli.app import app

SCENE = """\
name: small
family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
material: {E: 210e3, nu: 0.3, g_c: 1.0}
mesh: {element: T3, size: 2, grading: uniform}
fracture: {radii: 3}
"""


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def expect_failure(result: Result, status: int, *words: str) -> None:
    assert result.exit_code == status, result.output
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert "Traceback" not in result.output
    for word in words:
        assert word in result.stderr


def stderr_of(result: Result, status: int) -> str:
    """What a command says that ends with a status other than zero."""
    expect_failure(result, status)
    return result.stderr


def output_of(code: str, *arguments: str) -> str:
    """Run code in a new interpreter and return its output."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
