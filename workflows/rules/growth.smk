# Sections 5.2 to 5.5 of the paper: growing cracks, figures 9 to 16, films and the table.

GROWTH = "results/paper/growth"
GROWN = {study: f"{GROWTH}/{study}.nc" for study in STUDIES}


rule growth:
    # All variants of a study in one process: most take a second or two.
    input:
        scene=scene_of_study,
        compiled=rules.warm_up.output.stamp,
        code="workflows/paper/growth.py",
    output:
        data=f"{GROWTH}/{{study}}.nc",
    log:
        "results/logs/growth/{study}.log",
    benchmark:
        "results/benchmarks/growth/{study}.tsv"
    wildcard_constraints:
        study="|".join(STUDIES),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        variants=variants_of_study,
    message:
        "Growing cracks: {wildcards.study}"
    script:
        "../scripts/growth.py"


rule film:
    input:
        scene=scene_of_study,
        compiled=rules.warm_up.output.stamp,
        code=["workflows/paper/film.py", *PLOTTING],
    output:
        film=report(
            "results/paper/{study}.gif",
            caption="../report/film.rst",
            category="Films",
            labels={"film": "{study}"},
        ),
    log:
        "results/logs/growth/film_{study}.log",
    benchmark:
        "results/benchmarks/growth/film_{study}.tsv"
    wildcard_constraints:
        study="|".join(STUDIES),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        film=film_of_study,
    message:
        "Film of the growing cracks: {wildcards.study}"
    script:
        "../scripts/film.py"


rule fig9:
    input:
        growth=GROWN["edge"],
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig9.png",
            caption="../report/fig9.rst",
            category="5.2 Edge crack grows",
            labels={"figure": "9", "shows": "angle along the path"},
        ),
        data="results/paper/fig9.nc",
    log:
        "results/logs/growth/fig9.log",
    benchmark:
        "results/benchmarks/growth/fig9.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 9: angle along the path"
    script:
        "../scripts/fig9.py"


rule fig10:
    input:
        growth=GROWN["edge"],
        scene=STUDIES["edge"].scene,
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig10.png",
            caption="../report/fig10.rst",
            category="5.2 Edge crack grows",
            labels={"figure": "10", "shows": "trajectories"},
        ),
        data="results/paper/fig10.nc",
    log:
        "results/logs/growth/fig10.log",
    benchmark:
        "results/benchmarks/growth/fig10.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 10: trajectories"
    script:
        "../scripts/fig10.py"


rule fig11:
    input:
        growth=GROWN["shear"],
        scene=STUDIES["shear"].scene,
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig11.png",
            caption="../report/fig11.rst",
            category="5.3 Edge crack under shear",
            labels={"figure": "11", "shows": "path"},
        ),
        data="results/paper/fig11.nc",
    log:
        "results/logs/growth/fig11.log",
    benchmark:
        "results/benchmarks/growth/fig11.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 11: path"
    script:
        "../scripts/fig11.py"


rule fig12:
    input:
        growth=GROWN["shear"],
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig12.png",
            caption="../report/fig12.rst",
            category="5.3 Edge crack under shear",
            labels={"figure": "12", "shows": "convergence"},
        ),
        data="results/paper/fig12.nc",
    log:
        "results/logs/growth/fig12.log",
    benchmark:
        "results/benchmarks/growth/fig12.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 12: convergence"
    script:
        "../scripts/fig12.py"


rule fig13:
    input:
        growth=GROWN["holes"],
        scene=STUDIES["holes"].scene,
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig13.png",
            caption="../report/fig13.rst",
            category="5.4 Two holes, two cracks",
            labels={"figure": "13", "shows": "paths"},
        ),
        data="results/paper/fig13.nc",
    log:
        "results/logs/growth/fig13.log",
    benchmark:
        "results/benchmarks/growth/fig13.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 13: paths"
    script:
        "../scripts/fig13.py"


rule fig14:
    input:
        growth=GROWN["holes"],
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig14.png",
            caption="../report/fig14.rst",
            category="5.4 Two holes, two cracks",
            labels={"figure": "14", "shows": "driving force"},
        ),
        data="results/paper/fig14.nc",
    log:
        "results/logs/growth/fig14.log",
    benchmark:
        "results/benchmarks/growth/fig14.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 14: driving force"
    script:
        "../scripts/fig14.py"


rule fig15:
    input:
        growth=GROWN["beam"],
        scene=STUDIES["beam"].scene,
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig15.png",
            caption="../report/fig15.rst",
            category="5.5 Beam with three holes",
            labels={"figure": "15", "shows": "paths"},
        ),
        data="results/paper/fig15.nc",
    log:
        "results/logs/growth/fig15.log",
    benchmark:
        "results/benchmarks/growth/fig15.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Fig. 15: paths"
    script:
        "../scripts/fig15.py"


rule fig16:
    input:
        growth=GROWN["beam"],
        scene=STUDIES["beam"].scene,
        code=["workflows/paper/figures_growth.py", *PLOTTING],
    output:
        picture=report(
            "results/paper/fig16.png",
            caption="../report/fig16.rst",
            category="5.5 Beam with three holes",
            labels={"figure": "16", "shows": "near-miss"},
        ),
        data="results/paper/fig16.nc",
    log:
        "results/logs/growth/fig16.log",
    benchmark:
        "results/benchmarks/growth/fig16.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        sizes=[12, 8, 5, 3],
    message:
        "Fig. 16: near-miss"
    script:
        "../scripts/fig16.py"


rule claims_growth:
    input:
        **GROWN,
        code="workflows/paper/claims_growth.py",
    output:
        table="results/paper/sections_5_2_to_5_5.csv",
        markdown="results/paper/sections_5_2_to_5_5.md",
        page=report(
            "results/paper/sections_5_2_to_5_5.html",
            caption="../report/claims_growth.rst",
            category="5.2 to 5.5 Growing cracks",
            labels={"figure": "table", "shows": "paper, reference, cfmpm"},
        ),
    log:
        "results/logs/growth/claims.log",
    benchmark:
        "results/benchmarks/growth/claims.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Sections 5.2 to 5.5: deciding the paper's claims"
    script:
        "../scripts/claims_growth.py"
