# The studies of growing cracks, and what their rules ask about one of them.

STUDIES = SETTINGS.growth.studies()


def scene_of_study(wildcards):
    return STUDIES[wildcards.study].scene


def variants_of_study(wildcards):
    return STUDIES[wildcards.study].variants


def film_of_study(wildcards):
    """What of a study is filmed: the replaced values of one variant, and how often."""
    study = STUDIES[wildcards.study]
    return {"replaced": study.variants[study.film.variant], "every": study.film.every}
