# Sections 5.2 to 5.5 of the paper: growing cracks, figures 9 to 16, films and the table.

GROWTH = "results/paper/growth"
GROWN = {study: f"{GROWTH}/{study}.nc" for study in STUDIES}
# Made by workflows/study/rules.smk.
SCATTERED = {study: dataset_of(one.scatter) for study, one in STUDIES.items()}


rule growth:
    # All variants of a study in one job: most take a second or two.
    input:
        study=study_file,
        scene=scene_of_study,
        prescribed=PRESCRIBED,
        compiled=rules.warm_up.output.stamp,
        code=modules("growth"),
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
    message:
        "Growing cracks: {wildcards.study}"
    script:
        "jobs/growth.py"


rule film:
    input:
        scene=scene_of_study,
        prescribed=PRESCRIBED,
        compiled=rules.warm_up.output.stamp,
        code=[*modules("film"), *PLOTTING],
    output:
        film="results/paper/{study}.gif",
        shown=item(
            "results/paper/film_{study}.png",
            "report/film.rst",
            lambda wildcards: OF_STUDY[wildcards.study],
            f"Film: {FILM}",
        ),
    log:
        "results/logs/film/{study}.log",
    benchmark:
        "results/benchmarks/film/{study}.tsv"
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
        "jobs/film.py"


rule section_5_2:
    input:
        growth=GROWN["edge"],
        scatter=SCATTERED["edge"],
        scene=STUDIES["edge"].scene,
        prescribed=PRESCRIBED,
        code=[*modules("section_5_2"), *PLOTTING],
    output:
        fig9=figure(9, EDGE),
        fig9_data="results/paper/fig9.nc",
        fig10=figure(10, EDGE),
        fig10_data="results/paper/fig10.nc",
        scattered=figure("scatter_edge", EDGE),
        scattered_data="results/paper/scatter_edge.nc",
    log:
        "results/logs/section_5_2.log",
    benchmark:
        "results/benchmarks/section_5_2.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    params:
        variants=variants("edge", "as_printed_790", "as_printed_2584", "best"),
    message:
        "Section 5.2: figures 9 and 10, and many grids"
    script:
        "jobs/section_5_2.py"


rule section_5_3:
    input:
        growth=GROWN["shear"],
        scatter=SCATTERED["shear"],
        scene=STUDIES["shear"].scene,
        prescribed=PRESCRIBED,
        code=[*modules("section_5_3"), *PLOTTING],
        references=REFERENCES,
    output:
        fig11=figure(11, SHEAR),
        fig11_data="results/paper/fig11.nc",
        fig12=figure(12, SHEAR),
        fig12_data="results/paper/fig12.nc",
        convergence=figure("convergence_shear", SHEAR),
        convergence_data="results/paper/convergence_shear.nc",
        scattered=figure("scatter_shear", SHEAR),
        scattered_data="results/paper/scatter_shear.nc",
    log:
        "results/logs/section_5_3.log",
    benchmark:
        "results/benchmarks/section_5_3.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    params:
        variants=variants("shear", "as_printed", "best"),
    message:
        "Section 5.3: figures 11 and 12, convergence, and many grids"
    script:
        "jobs/section_5_3.py"


rule section_5_4:
    input:
        growth=GROWN["holes"],
        scatter=SCATTERED["holes"],
        scene=STUDIES["holes"].scene,
        prescribed=PRESCRIBED,
        code=[*modules("section_5_4"), *PLOTTING],
        references=REFERENCES,
    output:
        fig13=figure(13, HOLES),
        fig13_data="results/paper/fig13.nc",
        fig14=figure(14, HOLES),
        fig14_data="results/paper/fig14.nc",
        force=figure("driving_force_holes", HOLES),
        force_data="results/paper/driving_force_holes.nc",
        scattered=figure("scatter_holes", HOLES),
        scattered_data="results/paper/scatter_holes.nc",
    log:
        "results/logs/section_5_4.log",
    benchmark:
        "results/benchmarks/section_5_4.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    params:
        variants=variants("holes", "as_printed", "best"),
    message:
        "Section 5.4: figures 13 and 14, driving force, and many grids"
    script:
        "jobs/section_5_4.py"


rule section_5_5:
    input:
        growth=GROWN["beam"],
        scatter=SCATTERED["beam"],
        scene=STUDIES["beam"].scene,
        prescribed=PRESCRIBED,
        code=[*modules("section_5_5"), *PLOTTING],
        references=REFERENCES,
    output:
        fig15=figure(15, BEAM),
        fig15_data="results/paper/fig15.nc",
        fig16=figure(16, BEAM),
        fig16_data="results/paper/fig16.nc",
        near_miss=figure("near_miss_beam", BEAM),
        near_miss_data="results/paper/near_miss_beam.nc",
        scattered=figure("scatter_beam", BEAM),
        scattered_data="results/paper/scatter_beam.nc",
    log:
        "results/logs/section_5_5.log",
    benchmark:
        "results/benchmarks/section_5_5.tsv"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=5,
    params:
        sizes=SETTINGS.growth.near_miss_sizes(),
        variants=variants(
            "beam",
            *("as_printed_15_5", "as_printed_10_6", "as_printed_10_4", "best_15_5"),
        ),
    message:
        "Section 5.5: figures 15 and 16, the near-miss, and many grids"
    script:
        "jobs/section_5_5.py"


rule claims_growth:
    input:
        **GROWN,
        **{f"{study}_grids": path for study, path in SCATTERED.items()},
        code=modules("claims_growth"),
        statements=STATEMENTS,
        references=REFERENCES,
    output:
        table="results/paper/sections_5_2_to_5_5.csv",
        markdown="results/paper/sections_5_2_to_5_5.md",
        page=claims(
            "results/paper/sections_5_2_to_5_5.html",
            "report/claims.rst",
            "5.2 to 5.5 Growing cracks",
        ),
    log:
        "results/logs/claims_growth.log",
    benchmark:
        "results/benchmarks/claims_growth.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Sections 5.2 to 5.5: deciding the paper's claims"
    script:
        "jobs/claims_growth.py"


CLAIMS.append("results/paper/sections_5_2_to_5_5.csv")
