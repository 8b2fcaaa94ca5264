# Parameter studies, whole or in part: the same dataset as by `cfmpm study`.
#   snakemake study --configfile my_study.yaml    a study file of your own, or several
#   snakemake studies                             all of configs/studies
#   snakemake results/crack_length/study.nc       one of them, or of configs/paper/studies
from workflows.study.studies import (
    BATCH,
    DATASET,
    RETRIES,
    TIMED,
    Studies,
    is_last_attempt,
    more_memory,
)

PARAMETER_STUDIES = Studies(
    ROOT / "configs" / "studies",
    ROOT / "configs" / "paper" / "studies",
    GIVEN_STUDIES,
    whole=workflow.is_main_process,
)


rule study_batch:
    # The study file is no input: what of it matters to these members is in their keys.
    input:
        compiled=rules.warm_up.output.stamp,
    output:
        data=update(BATCH),
    log:
        "results/logs/study/{study}/{batch}.log",
    benchmark:
        f"results/benchmarks/{TIMED}.tsv"
    wildcard_constraints:
        study="[A-Za-z][A-Za-z0-9_-]*",
        batch=r"\d+",
    retries: RETRIES
    threads: 1
    resources:
        mem_mb=more_memory,
        runtime=60,
        last=is_last_attempt,
    params:
        file=PARAMETER_STUDIES.file,
        members=PARAMETER_STUDIES.members,
        hashes=PARAMETER_STUDIES.keys,
        losses=PARAMETER_STUDIES.losses,
    message:
        "Study {wildcards.study}, batch {wildcards.batch}"
    script:
        "jobs/study_batch.py"


rule study_dataset:
    input:
        parts=PARAMETER_STUDIES.parts,
    output:
        data=DATASET,
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
        file=PARAMETER_STUDIES.file,
        definition=PARAMETER_STUDIES.definition,
    message:
        "Gathering study {wildcards.study}"
    script:
        "jobs/study_dataset.py"


rule study:
    input:
        PARAMETER_STUDIES.given,


rule studies:
    input:
        PARAMETER_STUDIES.shipped(),
