# The studies of growing cracks, and what their rules ask about one of them.

STUDIES = SETTINGS.growth.studies()


def study_file(wildcards):
    return STUDIES[wildcards.study].study


def scene_of_study(wildcards):
    return STUDIES[wildcards.study].scene


def film_of_study(wildcards):
    """What of a study is filmed: the replaced values of one variant, and how often."""
    study = STUDIES[wildcards.study]
    return {"replaced": study.filmed(), "every": study.film.every}


# Their sections in the report and in the overview.
EDGE = "5.2 Edge crack grows"
SHEAR = "5.3 Edge crack under shear"
HOLES = "5.4 Two holes, two cracks"
BEAM = "5.5 Beam with three holes"
OF_STUDY = dict(edge=EDGE, shear=SHEAR, holes=HOLES, beam=BEAM)


def contribute_growth(study, drawing, figures):
    jobs = {
        "computation": [f"growth/{study}"],
        "figures": [drawing],
        "film": [f"film/{study}"],
    }
    contribute(OF_STUDY[study], figures, jobs, STUDIES[study], film=study)


contribute_growth(
    "edge",
    "section_5_2",
    {
        9: (
            "angle of CF along the path",
            "angle of growth over the crack length, on 790 and 2584 points",
        ),
        10: (
            "paths in the plate",
            "paths in the plate on 790 (a) and 2584 points (b)",
        ),
    },
)
contribute_growth(
    "shear",
    "section_5_3",
    {
        11: ("path under shear", "the plate, its load and its grid"),
        12: (
            "convergence of the path",
            "the path after 3, 10 and 15 steps (a to c), and by FEM (d)",
        ),
    },
)
contribute_growth(
    "holes",
    "section_5_4",
    {
        13: ("paths of two cracks", "the plate and its load"),
        14: ("driving force along the paths", "the paths by MPM beside those by FEM"),
    },
)
contribute_growth(
    "beam",
    "section_5_5",
    {
        15: ("paths in three specimens", "the beam and its load"),
        16: (
            "how the crack passes the bottom hole",
            "the paths beside those of experiments, case I (a) and case II (b)",
        ),
    },
)
