"""Every source of a result is an input of its rule."""

from __future__ import annotations

import json

import pytest

from workflows.execution.imports import modules_of

DRAWN_WITH_REFERENCES = ["large_strain", "section_5_3", "section_5_4", "section_5_5"]


@pytest.fixture(scope="module")
def inputs(root, tmp_path_factory, snakemake):
    """Inputs by rule, except those that depend on wildcards."""
    path = tmp_path_factory.mktemp("asking") / "Snakefile"
    path.write_text(
        f"include: {str(root / 'workflows' / 'Snakefile')!r}\n"
        "import json\n"
        "print(json.dumps({one.name: [path for path in one.input if isinstance(path, str)]\n"
        "                  for one in workflow.rules}))\n"
    )
    said = snakemake("--snakefile", str(path), "--list").stdout
    return json.loads(next(line for line in said.splitlines() if line.startswith("{")))


def test_modules_that_a_script_imports(tmp_path):
    package = tmp_path / "workflows"
    for folder in ("execution", "growth"):
        (package / folder).mkdir(parents=True)
    for name, lines in {
        "script": ["from workflows.execution.job import job", "from workflows.growth import a"],
        "growth/a": ["from workflows.growth.b import c", "from cfmpm.body.grid import Grid"],
        "growth/b": ["def c():", "    from workflows import d"],
        "d": ["from workflows.growth.a import b"],
        "execution/job": [],
        "other": [],
    }.items():
        (package / f"{name}.py").write_text("\n".join(lines))
    found = modules_of(package / "script.py", tmp_path)
    assert found == [f"workflows/{name}.py" for name in ("d", "growth/a", "growth/b")]


def test_every_module_of_a_script_is_an_input(root, inputs):
    scripts = list(root.glob("workflows/*/jobs/*.py"))
    assert len(scripts) > 20
    for script in scripts:
        assert set(modules_of(script, root)) <= set(inputs[script.stem]), script.stem
    # And so are those that a script imports by way of others.
    claims = {"growth/claims", "growth/outcomes", "reporting/claim_table", "reporting/html_page"}
    assert {f"workflows/{name}.py" for name in claims} <= set(inputs["claims_growth"])


def test_references_and_captions_are_inputs(root, inputs):
    references = {f"workflows/reference/{p.name}" for p in root.glob("workflows/reference/*.csv")}
    for rule in (*DRAWN_WITH_REFERENCES, "claims_growth"):
        assert references <= set(inputs[rule]), rule
    for name in ("shear_plate_limit", "edge_crack_line", "edge_crack_release"):
        assert f"workflows/reference/{name}.csv" in inputs["work_precision_data"]
    captions = {path.name for path in root.glob("workflows/*/report/fig*.rst")}
    assert captions == {f"fig{number}.rst" for number in range(4, 17)}
    shown = {path for path in inputs["overview"] if path.endswith(".rst")}
    sections = ("section_5_1", "large_strain", "growth")
    of_sections = {p for one in sections for p in root.glob(f"workflows/{one}/report/*.rst")}
    assert {root / path for path in shown} == {p for p in of_sections if p.name != "claims.rst"}
    statements = {f"workflows/statements/{p.name}" for p in root.glob("workflows/statements/*")}
    for rule in ("section_5_1", "large_strain", "claims_growth"):
        assert statements <= set(inputs[rule]), rule
