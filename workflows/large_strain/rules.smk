# Fig. 8 of the paper: the plate of section 5.1 under loads that make it half as long again and more.
from workflows.study.studies import dataset_of, timed_batches

LARGE = "5.1 Large strain"
PULLED = SETTINGS.large_strain
contribute(
    LARGE,
    {
        8: (
            "CF against load",
            "CF at ten loads, up to a strain of 50 %, beside an analytical solution",
        )
    },
    {
        "computation": [
            *timed_batches(PULLED.as_printed),
            *timed_batches(PULLED.study),
        ],
        "figures": ["large_strain"],
    },
    PULLED,
    extra={"large_strain_laws": "laws, formulations and grids up to twice the length"},
)


rule large_strain:
    # Variants and loads are members of studies, some of them a job: workflows/study/rules.smk.
    input:
        study=dataset_of(PULLED.study),
        as_printed=dataset_of(PULLED.as_printed),
        scene=PULLED.scene,
        references=REFERENCES,
        code=[*modules("large_strain"), *PLOTTING],
        statements=STATEMENTS,
    output:
        curves="results/paper/large_strain/curves.nc",
        steps="results/paper/large_strain/steps.nc",
        fig8=figure(8, LARGE),
        fig8_data="results/paper/fig8.nc",
        laws=figure("large_strain_laws", LARGE),
        laws_data="results/paper/large_strain_laws.nc",
        table="results/paper/large_strain.csv",
        markdown="results/paper/large_strain.md",
        page=claims("results/paper/large_strain.html", "report/claims.rst", LARGE),
    log:
        "results/logs/large_strain.log",
    benchmark:
        "results/benchmarks/large_strain.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 8 and its claims"
    script:
        "jobs/large_strain.py"


CLAIMS.append("results/paper/large_strain.csv")
