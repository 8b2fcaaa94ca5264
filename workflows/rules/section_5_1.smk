# Section 5.1 of the paper: the stationary single edge crack, figures 4 to 7 and the table.

S51 = "results/paper/section_5_1"
SERIES = {name: f"{S51}/{name}.nc" for name in PAPER.series}
SCENE = PAPER.scene


rule series:
    # All sizes of one element in one process: each takes less time than starting Python.
    input:
        scene=SCENE,
        compiled=rules.warm_up.output.stamp,
        code=["workflows/paper/section_5_1.py", "workflows/reference_fem.py"],
    output:
        data=f"{S51}/{{series}}.nc",
    log:
        "results/logs/section_5_1/{series}.log",
    benchmark:
        "results/benchmarks/section_5_1/{series}.tsv"
    wildcard_constraints:
        series="|".join(PAPER.series),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=5,
    params:
        meshes=meshes_of_series,
        radii=PAPER.radii,
    message:
        "Section 5.1: grids of {wildcards.series}, by MPM and by FEM"
    script:
        "../scripts/series.py"


rule grids:
    input:
        scene=SCENE,
        compiled=rules.warm_up.output.stamp,
        code="workflows/paper/section_5_1.py",
    output:
        data=f"{S51}/grids.nc",
    log:
        "results/logs/section_5_1/grids.log",
    benchmark:
        "results/benchmarks/section_5_1/grids.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    params:
        meshes={
            n: plain(PAPER.series["T3"][n])
            for n in sorted({*PAPER.drawn, *PAPER.swept})
        },
    message:
        "Section 5.1: grids and nodal forces for the pictures"
    script:
        "../scripts/grids.py"


rule fig4:
    input:
        grids=rules.grids.output.data,
        code=["workflows/paper/figures_5_1.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig4.png",
            caption="../report/fig4.rst",
            category="5.1 Stationary edge crack",
            labels={"figure": "4", "shows": "four discretisations"},
        ),
        data="results/paper/fig4.nc",
    log:
        "results/logs/section_5_1/fig4.log",
    benchmark:
        "results/benchmarks/section_5_1/fig4.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        drawn=PAPER.drawn,
    message:
        "Fig. 4: four discretisations"
    script:
        "../scripts/fig4.py"


rule fig5:
    input:
        series=SERIES["T3"],
        code=["workflows/paper/figures_5_1.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig5.png",
            caption="../report/fig5.rst",
            category="5.1 Stationary edge crack",
            labels={"figure": "5", "shows": "tip and domain, MPM and FEM"},
        ),
        data="results/paper/fig5.nc",
    log:
        "results/logs/section_5_1/fig5.log",
    benchmark:
        "results/benchmarks/section_5_1/fig5.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        radius=PAPER.domain_radius,
        converged=PAPER.converged,
    message:
        "Fig. 5: configurational force against the number of points"
    script:
        "../scripts/fig5.py"


rule fig6:
    input:
        series=SERIES["T3"],
        grids=rules.grids.output.data,
        code=["workflows/paper/figures_5_1.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig6.png",
            caption="../report/fig6.rst",
            category="5.1 Stationary edge crack",
            labels={"figure": "6", "shows": "domain radius"},
        ),
        data="results/paper/fig6.nc",
    log:
        "results/logs/section_5_1/fig6.log",
    benchmark:
        "results/benchmarks/section_5_1/fig6.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        swept=PAPER.swept,
        radius=PAPER.domain_radius,
        converged=PAPER.converged,
    message:
        "Fig. 6: configurational force against the domain radius"
    script:
        "../scripts/fig6.py"


rule fig7:
    input:
        **SERIES,
        code=["workflows/paper/figures_5_1.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig7.png",
            caption="../report/fig7.rst",
            category="5.1 Stationary edge crack",
            labels={"figure": "7", "shows": "T3 and T6"},
        ),
        data="results/paper/fig7.nc",
    log:
        "results/logs/section_5_1/fig7.log",
    benchmark:
        "results/benchmarks/section_5_1/fig7.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        radius=PAPER.domain_radius,
        converged=PAPER.converged,
    message:
        "Fig. 7: T3 against T6"
    script:
        "../scripts/fig7.py"


rule claims_5_1:
    input:
        **SERIES,
        scene=SCENE,
        code="workflows/paper/claims_5_1.py",
    output:
        table="results/paper/section_5_1.csv",
        markdown="results/paper/section_5_1.md",
        page=report(
            "results/paper/section_5_1.html",
            caption="../report/claims_5_1.rst",
            category="5.1 Stationary edge crack",
            labels={"figure": "table", "shows": "paper, reference, cfmpm"},
        ),
    log:
        "results/logs/section_5_1/claims.log",
    benchmark:
        "results/benchmarks/section_5_1/claims.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        radius=PAPER.domain_radius,
        converged=PAPER.converged,
        swept=PAPER.swept,
    message:
        "Section 5.1: deciding the paper's claims"
    script:
        "../scripts/claims_5_1.py"
