# Parameter studies, whole or in part: the same dataset as by `cfmpm study`.
#   snakemake study --configfile my_study.yaml    a study file of your own, or several
#   snakemake studies                             all of configs/studies
#   snakemake results/crack_length/study.nc       one of them
from workflows.studies import Studies

PARAMETER_STUDIES = Studies(
    ROOT / "configs" / "studies",
    workflow.overwrite_configfiles,
    whole=workflow.is_main_process,
)
STUDY = "results/{study}/study.nc"


def study_file(wildcards):
    return PARAMETER_STUDIES.file(wildcards.study)


def members_of_batch(wildcards):
    return PARAMETER_STUDIES.members(wildcards.study, int(wildcards.batch))


def keys_of_batch(wildcards):
    return PARAMETER_STUDIES.keys(wildcards.study, int(wildcards.batch))


def batches_of_study(wildcards):
    return expand(
        "results/{study}/members/batch_{batch}.npz",
        study=wildcards.study,
        batch=PARAMETER_STUDIES.batches(wildcards.study),
    )


def datasets_given(wildcards):
    if not PARAMETER_STUDIES.given:
        raise ValueError("no study given: --configfile my_study.yaml")
    return expand(STUDY, study=PARAMETER_STUDIES.given)


def definition_of_study(wildcards):
    return PARAMETER_STUDIES.definition(wildcards.study)


def more_memory(wildcards, attempt):
    return 2000 * attempt


rule study_batch:
    # The study file is no input: what of it matters to these members is in their keys.
    input:
        compiled=ancient(rules.warm_up.output.stamp),
    output:
        data=update("results/{study}/members/batch_{batch}.npz"),
    log:
        "results/logs/study/{study}_{batch}.log",
    benchmark:
        "results/benchmarks/study/{study}_{batch}.tsv"
    wildcard_constraints:
        study="[A-Za-z][A-Za-z0-9_-]*",
        batch=r"\d+",
    threads: 1
    retries: 2
    resources:
        mem_mb=more_memory,
        runtime=60,
    params:
        file=study_file,
        members=members_of_batch,
        hashes=keys_of_batch,
    message:
        "Study {wildcards.study}, batch {wildcards.batch}"
    script:
        "../scripts/study_batch.py"


rule study_dataset:
    input:
        parts=batches_of_study,
    output:
        data=STUDY,
    log:
        "results/logs/study/{study}.log",
    benchmark:
        "results/benchmarks/study/{study}.tsv"
    wildcard_constraints:
        study="[A-Za-z][A-Za-z0-9_-]*",
    threads: 1
    resources:
        mem_mb=4000,
        runtime=30,
    params:
        file=study_file,
        definition=definition_of_study,
    message:
        "Gathering study {wildcards.study}"
    script:
        "../scripts/study_dataset.py"


rule study:
    input:
        datasets_given,


rule studies:
    input:
        expand(STUDY, study=PARAMETER_STUDIES.shipped),
