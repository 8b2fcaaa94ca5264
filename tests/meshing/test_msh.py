"""Reader of mesh files: formats, signs of groups, names, damaged files."""

from __future__ import annotations

import re
from pathlib import Path

import gmsh
import numpy as np
import pytest

from cfmpm.meshing.msh import read_msh
from cfmpm.meshing.msh_numbers import DamagedError

# gmsh writes format 4.0 as text only, and no group names in format 1.
FORMATS = [(2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)]
SIGNED = {
    "left_then_right": [1, -3],
    "right_then_left": [-1, 3],
    "all_negative": [-2, -4],
    "one": [-1],
    "again": [1, -2],
}


def write_signed(path: Path, version: float, binary: int, order: int = 1, partitions: int = 0):
    """Two squares of side 2 side by side; groups of curves and surfaces with minus signs."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    cad = gmsh.model.geo
    at = [(0, 0), (2, 0), (4, 0), (4, 2), (2, 2), (0, 2)]
    points = [cad.addPoint(x, y, 0, 1) for x, y in at]
    for a, b in zip(points, [*points[1:], points[0]], strict=True):
        cad.addLine(a, b)  # 1 to 6
    middle = cad.addLine(points[1], points[4])
    cad.addPlaneSurface([cad.addCurveLoop([1, middle, 5, 6])])
    cad.addPlaneSurface([cad.addCurveLoop([2, 3, 4, -middle])])
    cad.synchronize()
    for name, curves in SIGNED.items():
        gmsh.model.addPhysicalGroup(1, curves, name=name)
    gmsh.model.addPhysicalGroup(1, [-6, 7], tag=99)
    gmsh.model.addPhysicalGroup(2, [1, -2], name="both")
    gmsh.model.addPhysicalGroup(2, [-2], name="second")
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(order)
    if partitions:
        gmsh.model.mesh.partition(partitions)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(path))
    gmsh.finalize()


def extents(contents) -> dict[str, float]:
    """Length of each group of curves, area of each group of surfaces."""
    x = contents.nodes
    a, b = (x[contents.lines[:, k]] for k in (0, 1))
    p, q, r = (x[contents.triangles[:, k]] for k in range(3))
    length = np.linalg.norm(b - a, axis=1)
    area = np.abs(np.cross(q - p, r - p)[:, 2]) / 2
    return {name: float(length[rows].sum()) for name, rows in contents.curves.items()} | {
        name: float(area[rows].sum()) for name, rows in contents.surfaces.items()
    }


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("partitions", [0, 2])
@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_no_part_of_a_group_is_lost_for_its_sign(tmp_path, version, binary, order, partitions):
    write_signed(tmp_path / "a.msh", version, binary, order, partitions)
    contents = read_msh((tmp_path / "a.msh").read_bytes())
    assert extents(contents) == pytest.approx(
        {
            "left_then_right": 4,
            "right_then_left": 4,
            "all_negative": 4,
            "one": 2,
            "again": 4,
            "curve_99": 4,
            "both": 8,
            "second": 4,
        }
    )


def test_format_1_has_numbers_for_names(tmp_path):
    write_signed(tmp_path / "a.msh", 1, 0)
    found = extents(read_msh((tmp_path / "a.msh").read_bytes()))
    assert found["curve_99"] == pytest.approx(4)
    assert {name[: name.index("_")] for name in found} == {"curve", "surface"}


TRIANGLE = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
1 7 "top"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
4
1 1 2 7 1 1 2
2 1 2 -7 1 3 2
3 2 2 5 1 1 2 3
4 2 2 6 1 1 3 4
$EndElements
"""


def test_groups_of_format_2_belong_to_elements(tmp_path):
    """Other programs write one entity only; the minus sign belongs to the group."""
    contents = read_msh(TRIANGLE.encode())
    assert extents(contents) == {"top": 2, "surface_5": 0.5, "surface_6": 0.5}


def test_other_byte_order():
    """A binary file with the other byte order."""
    swapped = b"$MeshFormat\n2.2 1 8\n\0\0\0\1\n$EndMeshFormat\n$Nodes\n3\n"
    for tag, place in enumerate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], 1):
        swapped += np.array(tag, ">i4").tobytes() + np.array(place, ">f8").tobytes()
    swapped += b"\n$EndNodes\n$Elements\n1\n"
    swapped += np.array([2, 1, 2, 1, 3, 1, 1, 2, 3], ">i4").tobytes() + b"\n$EndElements\n"
    assert extents(read_msh(swapped)) == {"surface_3": 0.5}


@pytest.mark.parametrize(
    "before",
    [
        "$Comments\nmade by hand\n$EndComments\n",
        "\n\n",
        "$Comments\n$MeshFormat is below\n$EndComments\n$Comments\n$EndComments\n",
        "$Owner\nsomebody\n$EndOwner\n\n",
        "$Comments\r\nfrom another system\r\n$EndComments\r\n",
    ],
)
def test_sections_that_say_nothing_of_the_mesh(before):
    assert extents(read_msh((before + TRIANGLE).encode()))["top"] == 2
    assert extents(read_msh((TRIANGLE + before).encode()))["top"] == 2


@pytest.mark.parametrize("name", ["top edge", "1st", "a.b", "Größe", "日本", 'a "b"', "x/y", "-1"])
def test_names_of_groups_are_free(name):
    assert name in read_msh(TRIANGLE.replace("top", name).encode()).curves


def test_names_in_latin_1_and_in_parts():
    assert "côté" in read_msh(TRIANGLE.replace("top", "côté").encode("latin-1")).curves
    assert "é" in read_msh(TRIANGLE.replace("top", "e\u0301").encode()).curves


DAMAGE = {
    "not whole": (r"\$EndElements\n", "", "ends within $Elements"),
    "half": (r"3 1 1 0\n(.|\n)*", "", "ends within $Nodes"),
    "text": ("1 1 0", "1 one 0", "no number"),
    "count of nodes": (r"\n4\n1 0", r"\n5\n1 0", "shorter"),
    "fewer": (r"\n4\n1 0", r"\n3\n1 0", "longer"),
    "huge": (r"\n4\n1 0", r"\n4000000000000\n1 0", "shorter"),
    "negative": (r"\n4\n1 0", r"\n-4\n1 0", "negative"),
    "count of elements": (r"\n4\n1 1", r"\n40000000000\n1 1", "as many elements"),
    "type": ("3 2 2 5", "3 200 2 5", "type 200"),
    "tags": ("3 2 2 5", "3 2 999999999 5", "none"),
    "many tags": ("3 2 2 5", "3 2 99999 5", "shorter"),
    "node": ("1 1 3 4", "1 1 3 9", "node 9, which is not in the file"),
    "fraction": ("1 1 3 4", "1 1 3 3.5", "no whole number"),
    "twice": (r"\n4 0 1 0", r"\n3 0 1 0", "1 nodes have the number"),
    "nan": ("4 0 1 0", "4 nan 1 0", "coordinates that are no numbers"),
    "far": ("4 0 1 0", "4 1e300 1 0", "coordinates that are no numbers"),
    "format": ("2.2 0", "9.9 0", "has format '9.9'"),
    "kind": ("2.2 0 8", "2.2 7 8", "needs 0 or 1"),
    "binary": ("2.2 0 8", "2.2 1 8", "has no number 1"),
    "names": ('1 7 "top"', "1 7 top", "$PhysicalNames needs"),
    "between": (r"\$Nodes", "Nodes", "no section begins at byte"),
    "again": (r"(\$Nodes(.|\n)*)\$Elements", r"\1\1$Elements", "has $Nodes twice"),
    "no format": (r"^(.|\n)*EndMeshFormat\n", "", "before $MeshFormat"),
    "no triangles": (r"\n3 2 2(.|\n)*6 1 1 3 4", "", "as many elements"),
    "no nodes": (r"\$Nodes(.|\n)*EndNodes\n", "", "no nodes"),
    "quads": ("3 2 2 5 1 1 2 3", "3 3 2 5 1 1 2 3 4", "has quadrilaterals"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damaged_files_are_refused_in_one_line(kind):
    old, new, reason = DAMAGE[kind]
    damaged, n = re.subn(old, new, TRIANGLE, count=1)
    assert n == 1
    with pytest.raises(DamagedError) as caught:
        read_msh(damaged.encode())
    assert reason in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [b"", b" \n", b"\0\0", b"hello", b"$", b"$MeshFormat"])
def test_what_is_no_mesh_at_all(data):
    with pytest.raises(DamagedError):
        read_msh(data)
