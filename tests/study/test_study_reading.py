"""Reading of study files, and messages for invalid ones."""

from __future__ import annotations

from pathlib import Path

import pytest
from study_texts import FAILING, STUDY, write_study

from cfmpm.errors import Problem, SceneError
from cfmpm.scene import load_scene
from cfmpm.study import reading
from cfmpm.study.expansion import broken_rules
from cfmpm.study.layout import RESERVED
from cfmpm.study.model import Study
from cfmpm.study.reading import label, load_study
from cfmpm.versions import versions


def refused(folder: Path, text: str) -> list[Problem]:
    with pytest.raises(SceneError) as caught:
        load_study(write_study(folder, text))
    assert "pydantic" not in str(caught.value)
    return caught.value.problems


def test_members_are_scenes_of_the_base(tmp_path: Path) -> None:
    plan = load_study(write_study(tmp_path))
    assert [axis.name for axis in plan.axes] == ["length", "E"]
    assert [(one.values["length"], one.values["E"]) for one in plan.members] == [
        (2, 1e5),
        (2, 2e5),
        (4, 1e5),
        (4, 2e5),
    ]
    for one in plan.members:
        replaced = {
            "family.crack_length": one.values["length"],
            "material.E": one.values["E"],
        }
        assert one.scene == load_scene(tmp_path / "small.yaml", replaced)


def test_the_base_may_be_written_out(tmp_path: Path) -> None:
    scene = "".join(
        f"  {line}\n"
        for line in (write_study(tmp_path).parent / "small.yaml").read_text().splitlines()
    )
    inline = write_study(tmp_path, STUDY.replace("base: small.yaml", f"base:\n{scene}"))
    assert [one.scene for one in load_study(inline).members] == [
        one.scene for one in load_study(write_study(tmp_path, STUDY, "other.yaml")).members
    ]


def test_replaced_values_come_before_the_parameters(tmp_path: Path) -> None:
    text = (
        "name: one\nbase: small.yaml\n"
        "replace: {mesh.size: 3, mesh.grading: {tip_size: 0.5, growth: 0.2}}\n"
        "zip:\n  finest: {key: mesh.grading.tip_size, values: [1, 2]}\n"
    )
    scenes = [one.scene for one in load_study(write_study(tmp_path, text)).members]
    assert [scene.mesh.size for scene in scenes] == [3, 3]
    assert [scene.mesh.grading.model_dump() for scene in scenes] == [
        {"tip_size": 1, "growth": 0.2},
        {"tip_size": 2, "growth": 0.2},
    ]


def test_a_part_of_the_members(tmp_path: Path) -> None:
    path = write_study(tmp_path)
    whole = load_study(path).members
    assert load_study(path, range(1, 3)).members == whole[1:3]
    # Only those asked for are checked.
    path = write_study(tmp_path, STUDY.replace("[2, 4]", "[2, 40]"))
    assert load_study(path, range(2)).members == whole[:2]


def test_keys_change_with_the_scene_and_the_program(tmp_path: Path, monkeypatch) -> None:
    keys = [one.key for one in load_study(write_study(tmp_path)).members]
    assert len(set(keys)) == len(keys)
    other = STUDY.replace("name: lengths", "name: other").replace("[2, 4]", "[2, 3]")
    again = [one.key for one in load_study(write_study(tmp_path, other)).members]
    assert again[:2] == keys[:2]
    assert not set(again[2:]) & set(keys)
    monkeypatch.setattr(reading, "program_hash", lambda: "another one")
    later = [one.key for one in load_study(write_study(tmp_path)).members]
    assert not set(later) & set(keys)


def test_keys_change_with_the_versions_that_decide_numbers(tmp_path: Path, monkeypatch) -> None:
    def key() -> str:
        reading.program_hash.cache_clear()
        return load_study(write_study(tmp_path)).members[0].key

    first = key()
    try:
        for name in ("numpy", "numba", "gmsh", "kvxopt"):
            found = {**versions(), name: "0.0"}
            monkeypatch.setattr(reading, "versions", lambda found=found: found)
            assert key() != first
        monkeypatch.setattr(reading, "versions", lambda: {**versions(), "xarray": "0.0"})
        assert key() == first
    finally:
        reading.program_hash.cache_clear()


def test_a_long_list_is_not_checked_by_pairs() -> None:
    # By pairs it would take many minutes.
    study = {"name": "a", "base": "b", "product": {"x": {"key": "c", "linspace": [0, 1, 100_000]}}}
    assert not list(broken_rules(Study.model_validate(study), RESERVED))


@pytest.mark.parametrize("key", ["output.every", "growth.increments"])
def test_equally_spaced_whole_numbers_may_be_counts(key: str, tmp_path: Path) -> None:
    text = STUDY.replace("material.E, linspace: [100e3, 200e3, 2]", f"{key}, linspace: [2, 8, 4]")
    replaced = "replace: {material.g_c: 1, growth: {control: load}}\nproduct:"
    members = load_study(write_study(tmp_path, text.replace("product:", replaced))).members
    first, second = key.split(".") if "." in key else (key, "")
    found = [getattr(one.scene, first) for one in members]
    found = [getattr(value, second) if second else value for value in found]
    assert found == [2, 4, 6, 8] * 2


@pytest.mark.parametrize("key", ["fracture.radii", "load_steps"])
@pytest.mark.parametrize("kind", ["linspace", "geomspace"])
def test_a_range_of_counts_or_lengths_is_refused(key: str, kind: str, tmp_path: Path) -> None:
    """Lengths such as 10, 15, 20 mm would be read as numbers of domains."""
    text = STUDY.replace("material.E, linspace: [100e3, 200e3, 2]", f"{key}, {kind}: [10, 20, 3]")
    with pytest.raises(SceneError) as caught:
        load_study(write_study(tmp_path, text))
    (problem,) = caught.value.problems
    assert (problem.key, problem.line) == ("product.E.key", 5)
    assert problem.reason == (
        f"{key} is a count or a list: for counts write them as values, such as [1, 2, 4]; for "
        f"numbers of the list take {key}[0]"
    )
    counts = text.replace(f"{kind}: [10, 20, 3]", "values: [1, 2, 4]")
    first, _, second = key.partition(".")
    found = [getattr(one.scene, first) for one in load_study(write_study(tmp_path, counts)).members]
    assert [getattr(value, second) if second else value for value in found] == [1, 2, 4] * 2
    entry = text.replace(key, f'"{key}[0]"').replace(
        "product:", "replace: {load_steps: [1.0], fracture.radii: [1]}\nproduct:"
    )
    entry = (
        entry.replace("load_steps: [1.0], ", "")
        if second
        else entry.replace(", fracture.radii: [1]", "")
    )
    found = [getattr(one.scene, first) for one in load_study(write_study(tmp_path, entry)).members]
    lengths = [getattr(value, second) if second else value for value in found]
    middle = 15.0 if kind == "linspace" else pytest.approx(200**0.5)
    assert lengths == [[10.0], [middle], [20.0]] * 2


def test_draws_of_counts_or_lengths_are_refused(tmp_path: Path) -> None:
    text = STUDY + (
        "latin_hypercube:\n  samples: 2\n  parameters:\n"
        "    R: {key: fracture.radii, distribution: uniform, arguments: {loc: 2, scale: 5}}\n"
    )
    with pytest.raises(SceneError, match=r"R\.key: fracture\.radii is a count or a list: for"):
        load_study(write_study(tmp_path, text))


def test_labels(tmp_path: Path) -> None:
    text = STUDY + "zip:\n  nu: {key: material.nu, values: [0.2, 0.3]}\n"
    plan = load_study(write_study(tmp_path, text))
    one = plan.members[-1]
    assert one.index == (1, 1, 1)
    said = label(plan.axes, one.index)
    assert said == "length=4, E=200000, sample=1 (nu=0.3)"


REFUSED = [
    # text, changed to; line, key, words
    ("product:", "produkt:", 3, "produkt", "did you mean product?"),
    (
        "{key: family.crack_length, values: [2, 4]}",
        "{values: [2]}",
        4,
        "product.length.key",
        "is missing: key of the scene, such as",
    ),
    ("values: [2, 4]", "valus: [2, 4]", 4, "product.length.valus", "did you mean values?"),
    ("values: [2, 4]", "values: []", 4, "product.length.values", "must be a list of values"),
    (
        "values: [2, 4]",
        "values: [2, 4], linspace: [1, 2, 3]",
        4,
        "product.length",
        "needs one of values, linspace, geomspace",
    ),
    ("values: [2, 4]", "values: [2, 4, 2]", 4, "product.length", "has a value twice"),
    (
        "linspace: [100e3, 200e3, 2]",
        "linspace: [100e3, 200e3]",
        5,
        "product.E.linspace",
        "must be first value, last value and how many",
    ),
    (
        "linspace: [100e3, 200e3, 2]",
        "linspace: [100e3, 200e3, 2.5]",
        5,
        "product.E.linspace[2]",
        "must be a whole number",
    ),
    (
        "linspace: [100e3, 200e3, 2]",
        "geomspace: [0, 200e3, 2]",
        5,
        "product.E.geomspace",
        "same sign, not zero",
    ),
    ("material.E", "material..E", 5, "product.E.key", "not a key such as mesh.size"),
    ("material.E", "family", 5, "product.E.key", "is what length sets, or a part of it"),
    ("  E:", "  G:", 5, "product.G", "G is a name in the dataset of every study"),
    ("  E:", "  2nd:", 5, "product.2nd", "must be letters, digits"),
    ("base: small.yaml", "base: smal.yaml", 2, "base", "no such file"),
    ("base: small.yaml", "base: 7", 2, "base", "must be the path of a scene file, or a scene"),
    ("product:", "zip: {}\nproducts:", 4, "products", "did you mean product?"),
]


@pytest.mark.parametrize(("old", "new", "line", "key", "words"), REFUSED)
def test_bad_study(old, new, line, key, words, tmp_path: Path) -> None:
    assert STUDY.count(old) == 1
    problems = refused(tmp_path, STUDY.replace(old, new))
    assert (str(tmp_path / "study.yaml"), line, key) in [(p.file, p.line, p.key) for p in problems]
    assert any(words in p.reason for p in problems)


BAD_SECTIONS = [
    ("", "product", "no parameters"),
    (
        "zip: {a: {key: mesh.size, values: [1, 2]}, b: {key: material.E, values: [1]}}",
        "zip",
        "the numbers of values differ: a 2, b 1",
    ),
    (
        "zip: {a: {key: mesh.size, values: [1]}}\n"
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: norm}}}",
        "zip",
        "leave one out",
    ),
    (
        "product: {a: {key: mesh.size, values: [1]}}\nzip: {a: {key: material.E, values: [1]}}",
        "zip.a",
        "is the name of another parameter too",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: normal}}}",
        "latin_hypercube.parameters.b.distribution",
        "unknown distribution normal; did you mean norm",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: lognorm}}}",
        "latin_hypercube.parameters.b.arguments",
        "s is missing",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: norm, "
        "arguments: {scal: 1}}}}",
        "latin_hypercube.parameters.b.arguments.scal",
        "did you mean scale?",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: norm, "
        "arguments: {scale: -1}}}}",
        "latin_hypercube.parameters.b.arguments.scale",
        "must be greater than 0",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: lognorm, "
        "arguments: {s: -0.2}}}}",
        "latin_hypercube.parameters.b.arguments.s",
        "no distribution lognorm has s: -0.2",
    ),
    (
        "latin_hypercube: {samples: 2, parameters: {b: {key: material.E, distribution: beta, "
        "arguments: {a: 1, b: -3}}}}",
        "latin_hypercube.parameters.b.arguments",
        "no distribution beta has a: 1, b: -3",
    ),
    (
        "replace: {material.E: 1e5}\nzip: {a: {key: material.E, values: [1e5]}}",
        "zip.a.key",
        "material.E of replace is lost",
    ),
    (
        "replace: {mesh.size: 1}\nproduct: {a: {key: mesh, values: [{size: 2}]}}",
        "product.a.key",
        "sets mesh, and mesh.size of replace is lost",
    ),
    (
        "zip: {a: {key: material.E, values: [1e5, '1e5']}}",
        "zip.a",
        "'1e5' is text: write the number without quotes",
    ),
    (
        "product: {a: {key: mesh, values: [{size: 2}, {size: 2.0}, {size: 2}]}}",
        "product.a",
        "has a value twice",
    ),
    (
        "latin_hypercube: {samples: 0, parameters: {b: {key: material.E, distribution: norm}}}",
        "latin_hypercube.samples",
        "must be at least 1",
    ),
    (
        "product: {a: {key: mesh.size, linspace: [1, 2, 2000]}, "
        "b: {key: material.E, linspace: [1, 2, 51]}}",
        "",
        "would have 102000 members; the limit is 100000",
    ),
]


@pytest.mark.parametrize(("sections", "key", "words"), BAD_SECTIONS)
def test_bad_sections(sections, key, words, tmp_path: Path) -> None:
    (problem,) = refused(tmp_path, f"name: bad\nbase: small.yaml\n{sections}\n")
    assert problem.key == key
    assert words in problem.reason


def test_a_bad_member_is_named_with_file_line_and_key(tmp_path: Path) -> None:
    problems = refused(tmp_path, STUDY.replace("[2, 4]", "[2, 40]"))
    file = str(tmp_path / "study.yaml")
    assert [str(problem) for problem in problems] == [
        f"{file}:4:3: in 2 members, such as length=40, E=100000: family.crack_length: "
        "must be less than the width, 10",
        f"{file}: 2 of 4 members are refused; nothing was run",
    ]


def test_mistakes_that_differ_in_their_numbers_are_told_once(tmp_path: Path) -> None:
    """Example: a distribution with values below zero."""
    told, _ = refused(tmp_path, STUDY.replace("[2, 4]", "[2, -3, -4.5e-3]"))
    assert told.key == "in 4 members, such as length=-3, E=100000: family.crack_length"
    # pydantic before 2.12 tells the number as it was converted.
    assert told.reason.endswith(("got -3", "got -3.0"))


def test_what_is_wrong_in_the_base_keeps_its_place_there(tmp_path: Path) -> None:
    path = write_study(tmp_path)
    scene = tmp_path / "small.yaml"
    scene.write_text(scene.read_text().replace("nu: 0.3", "nu: 0.7"))
    with pytest.raises(SceneError) as caught:
        load_study(path)
    told = str(caught.value.problems[0])
    assert told.startswith(f"{path}:2:1: in 4 members, such as length=2, E=100000: {scene}:3:")
    assert "material.nu: must be less than 0.5; got 0.7" in told


def test_a_key_that_the_scene_does_not_have(tmp_path: Path) -> None:
    problems = refused(tmp_path, STUDY.replace("material.E", '"loads[0].traction"'))
    assert problems[0].line == 5
    assert problems[0].key == "in 4 members, such as length=2, E=100000: loads[0].traction"
    assert "there is no entry [0]" in problems[0].reason


def test_few_of_many_problems_are_told(tmp_path: Path) -> None:
    words = ", ".join(f"x{letter}" for letter in "abcdefghijklmnop")
    laws = STUDY.replace(
        "material.E, linspace: [100e3, 200e3, 2]", f"material.law, values: [{words}]"
    )
    problems = refused(tmp_path, laws)
    assert len(problems) == reading.MOST_TOLD + 1
    assert problems[-1].reason == "32 of 32 members are refused; nothing was run"


def test_a_part_of_a_list_is_told_at_its_parameter(tmp_path: Path) -> None:
    """The rule concerns the whole crack, whose other values are in the base."""
    text = (
        FAILING.split("product:")[0]
        + 'product:\n  end: {key: "geometry.cracks[0].points[1][0]", values: [4, 14]}\n'
    )
    (problem,) = refused(tmp_path, text)
    assert text.splitlines()[problem.line - 1].startswith("  end:")
    assert problem.key.startswith("member end=14: geometry.cracks[0]")


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "the file is empty"), ("[1, 2]", "must be a mapping"), ("a: [", "not valid YAML")],
)
def test_no_study_at_all(text, words, tmp_path: Path) -> None:
    assert words in refused(tmp_path, text)[0].reason


def test_names_of_the_dataset_are_reserved() -> None:
    for name in ("step", "tip", "sample", "G", "final_G", "status", "load_factor", "G_spread"):
        study = Study.model_validate(
            {"name": "a", "base": "b", "zip": {name: {"key": "c", "values": [1]}}}
        )
        assert [reason for _, reason in broken_rules(study, RESERVED)], name


def test_checking_ends_where_a_thousand_members_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "MOST_REFUSED", 20)
    problems = refused(tmp_path, STUDY.replace("[100e3, 200e3, 2]", "[-200e3, -100e3, 50]"))
    assert "in 20 members" in str(problems[0])
    assert problems[-1].reason == "20 of the first 20 members are refused; nothing was run"
