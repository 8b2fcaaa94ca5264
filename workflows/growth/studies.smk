# The studies of growing cracks, and what their rules ask about one of them.

from workflows.study.studies import dataset_of, timed_batches

STUDIES = SETTINGS.growth.studies()


def study_file(wildcards):
    return STUDIES[wildcards.study].study


def scene_of_study(wildcards):
    return STUDIES[wildcards.study].scene


def film_of_study(wildcards):
    """What of a study is filmed: the replaced values of one variant, and how often."""
    study = STUDIES[wildcards.study]
    return {"replaced": study.filmed(), "every": study.film.every}


def variants(study, *names):
    """What variants of a study replace in its scene."""
    return {name: STUDIES[study].replaced(name) for name in names}


# Their sections in the report and in the overview.
EDGE = "5.2 Edge crack grows"
SHEAR = "5.3 Edge crack under shear"
HOLES = "5.4 Two holes, two cracks"
BEAM = "5.5 Beam with three holes"
OF_STUDY = dict(edge=EDGE, shear=SHEAR, holes=HOLES, beam=BEAM)


def contribute_growth(study, drawing, figures, extra):
    jobs = {
        "computation": [f"growth/{study}"],
        "many grids": timed_batches(STUDIES[study].scatter),
        "figures": [drawing],
        "film": [f"film/{study}"],
    }
    contribute(OF_STUDY[study], figures, jobs, STUDIES[study], film=study, extra=extra)


contribute_growth(
    "edge",
    "section_5_2",
    {
        9: (
            "angle of growth over the crack length",
            "angle of growth over the crack length, on 790 and 2584 points",
        ),
        10: (
            "paths in the plate",
            "paths in the plate on 790 (a) and 2584 points (b)",
        ),
    },
    {"scatter_edge": "the edge crack on twenty grids"},
)
contribute_growth(
    "shear",
    "section_5_3",
    {
        11: ("plate, load and grid", "the plate, its load and its grid"),
        12: (
            "the crack under shear as it grows",
            "the path after 3, 10 and 15 steps (a to c), and by FEM (d)",
        ),
    },
    {
        "convergence_shear": "convergence of the path under shear",
        "scatter_shear": "the crack under shear on ten grids",
    },
)
contribute_growth(
    "holes",
    "section_5_4",
    {
        13: ("plate with two holes and its load", "the plate and its load"),
        14: ("paths of two cracks", "the paths by MPM beside those by FEM"),
    },
    {
        "driving_force_holes": "driving force along the paths, and edges free to move",
        "scatter_holes": "two cracks, two holes on ten grids",
    },
)
contribute_growth(
    "beam",
    "section_5_5",
    {
        15: ("beam with three holes and its load", "the beam and its load"),
        16: (
            "paths in the beam",
            "the paths beside those of experiments, case I (a) and case II (b)",
        ),
    },
    {
        "near_miss_beam": "how the crack passes the bottom hole",
        "scatter_beam": "the beam on ten grids",
    },
)
