"""What results are made from is an input of the rule that makes them."""

from __future__ import annotations

import json

import pytest

from workflows.imports import modules_of

DRAWN_WITH_REFERENCES = ["large_strain", "section_5_3", "section_5_4", "section_5_5"]


@pytest.fixture(scope="module")
def inputs(root, tmp_path_factory, snakemake):
    """Inputs by rule, but for those that depend on wildcards."""
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
    (package / "paper").mkdir(parents=True)
    for name, text in {
        "script": "from workflows.job import job\nfrom workflows.paper import a\nimport numpy\n",
        "paper/a": "from workflows.paper.b import c\nfrom cfmpm.grid import Grid\n",
        "paper/b": "def c():\n    from workflows import d\n",
        "d": "from workflows.paper.a import b\n",
        "job": "",
        "other": "",
    }.items():
        (package / f"{name}.py").write_text(text)
    found = modules_of(package / "script.py", tmp_path)
    assert found == [f"workflows/{name}.py" for name in ("d", "paper/a", "paper/b")]


def test_every_module_of_a_script_is_an_input(root, inputs):
    scripts = list((root / "workflows" / "scripts").glob("*.py"))
    assert len(scripts) > 20
    for script in scripts:
        assert set(modules_of(script, root)) <= set(inputs[script.stem]), script.stem
    # And so are those that a script imports by way of others.
    claims = {"paper/claims_growth", "paper/figures_growth", "paper/growth", "paper/table", "page"}
    assert {f"workflows/{name}.py" for name in claims} <= set(inputs["claims_growth"])


def test_references_and_captions_are_inputs(root, inputs):
    references = {f"workflows/reference/{p.name}" for p in root.glob("workflows/reference/*.csv")}
    for rule in (*DRAWN_WITH_REFERENCES, "claims_growth"):
        assert references <= set(inputs[rule]), rule
    for name in ("shear_plate_limit", "edge_crack_line", "edge_crack_release"):
        assert f"workflows/reference/{name}.csv" in inputs["work_precision_data"]
    captions = {f"workflows/report/fig{number}.rst" for number in range(4, 17)}
    assert captions <= set(inputs["overview"])
