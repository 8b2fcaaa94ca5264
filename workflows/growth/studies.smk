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
