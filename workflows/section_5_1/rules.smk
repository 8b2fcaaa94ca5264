# Section 5.1 of the paper: the stationary single edge crack, figures 4 to 7 and the table.

from workflows.section_5_1.settings import SERIES
from workflows.study.studies import dataset_of, timed_batches

STATIONARY = "5.1 Stationary edge crack"
PAPER = SETTINGS.section_5_1
S51 = "results/paper/section_5_1"
contribute(
    STATIONARY,
    {
        4: (
            "discretisations",
            "the plate with its load (a), and grids of 384, 790, 1530 and 2584 points (b to e)",
        ),
        5: (
            "CF at the tip and on a domain, MPM and FEM",
            "norm (a) and angle (b) of CF on seven grids, at the tip and on a domain; the same by "
            "FEM (c, d)",
        ),
        6: (
            "CF by the radius of its domain",
            "norm and angle of CF by the radius, and the configurational forces around the tip, "
            "on 2584 and on 8068 points",
        ),
        7: (
            "triangles of three and of six nodes",
            "norm and angle of CF on grids of both kinds of triangles",
        ),
    },
    {"computation": timed_batches(PAPER.study), "figures": ["section_5_1"]},
    PAPER,
    extra={"error_by_unknowns": "error of CF by the number of unknowns"},
)


rule section_5_1_data:
    # Each grid is a member of the study, a few of them a job: workflows/study/rules.smk.
    input:
        study=dataset_of(PAPER.study),
        scene=PAPER.scene,
        code=modules("section_5_1_data"),
    output:
        **{name: f"{S51}/{name}.nc" for name in SERIES},
        grids=f"{S51}/grids.nc",
    log:
        "results/logs/section_5_1_data.log",
    benchmark:
        "results/benchmarks/section_5_1_data.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        drawn=PAPER.kept(),
    message:
        "Section 5.1: the grids sorted by series"
    script:
        "jobs/section_5_1_data.py"


rule section_5_1:
    input:
        **{name: rules.section_5_1_data.output[name] for name in SERIES},
        grids=rules.section_5_1_data.output.grids,
        scene=PAPER.scene,
        code=[*modules("section_5_1"), *PLOTTING],
        statements=STATEMENTS,
    output:
        fig4=figure(4, STATIONARY),
        fig4_data="results/paper/fig4.nc",
        fig5=figure(5, STATIONARY),
        fig5_data="results/paper/fig5.nc",
        fig6=figure(6, STATIONARY),
        fig6_data="results/paper/fig6.nc",
        fig7=figure(7, STATIONARY),
        fig7_data="results/paper/fig7.nc",
        error=figure("error_by_unknowns", STATIONARY),
        error_data="results/paper/error_by_unknowns.nc",
        table=f"{S51}.csv",
        markdown=f"{S51}.md",
        page=claims(f"{S51}.html", "report/claims.rst", STATIONARY),
    log:
        "results/logs/section_5_1.log",
    benchmark:
        "results/benchmarks/section_5_1.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        drawn=PAPER.drawn,
        swept=PAPER.swept,
        radius=PAPER.domain_radius,
        converged=PAPER.converged,
    message:
        "Section 5.1: figures 4 to 7, and deciding the paper's claims"
    script:
        "jobs/section_5_1.py"


CLAIMS.append(f"{S51}.csv")
