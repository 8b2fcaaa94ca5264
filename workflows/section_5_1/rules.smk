# Section 5.1 of the paper: the stationary single edge crack, figures 4 to 7 and the table.

from workflows.section_5_1.settings import SERIES

STATIONARY = "5.1 Stationary edge crack"
PAPER = SETTINGS.section_5_1
S51 = "results/paper/section_5_1"


rule section_5_1_data:
    # All grids in one job: each takes less time than starting Python.
    input:
        study=PAPER.study,
        scene=PAPER.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("section_5_1_data", "fem_beside"),
    output:
        **{name: f"{S51}/{name}.nc" for name in SERIES},
        grids=f"{S51}/grids.nc",
    log:
        "results/logs/section_5_1_data.log",
    benchmark:
        "results/benchmarks/section_5_1_data.tsv"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        drawn=[*PAPER.drawn, *PAPER.swept],
    message:
        "Section 5.1: all grids, by MPM and by FEM"
    script:
        "jobs/section_5_1_data.py"


rule section_5_1:
    input:
        **{name: rules.section_5_1_data.output[name] for name in SERIES},
        grids=rules.section_5_1_data.output.grids,
        scene=PAPER.scene,
        code=[*modules("section_5_1"), *PLOTTING],
    output:
        fig4=figure(4, "four discretisations", STATIONARY),
        fig4_data="results/paper/fig4.nc",
        fig5=figure(5, "tip and domain, MPM and FEM", STATIONARY),
        fig5_data="results/paper/fig5.nc",
        fig6=figure(6, "domain radius", STATIONARY),
        fig6_data="results/paper/fig6.nc",
        fig7=figure(7, "T3 and T6", STATIONARY),
        fig7_data="results/paper/fig7.nc",
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


contribute(STATIONARY, [4, 5, 6, 7], ["section_5_1_data", "section_5_1"])
CLAIMS["5.1"] = f"{S51}.csv"
