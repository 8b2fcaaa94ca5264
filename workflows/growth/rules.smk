# Sections 5.2 to 5.5 of the paper: growing cracks, figures 9 to 16, films and the table.

GROWTH = "results/paper/growth"
GROWN = {study: f"{GROWTH}/{study}.nc" for study in STUDIES}


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
        scene=STUDIES["edge"].scene,
        code=[*modules("section_5_2"), *PLOTTING],
    output:
        fig9=figure(9, EDGE),
        fig9_data="results/paper/fig9.nc",
        fig10=figure(10, EDGE),
        fig10_data="results/paper/fig10.nc",
    log:
        "results/logs/section_5_2.log",
    benchmark:
        "results/benchmarks/section_5_2.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Section 5.2: figures 9 and 10"
    script:
        "jobs/section_5_2.py"


rule section_5_3:
    input:
        growth=GROWN["shear"],
        scene=STUDIES["shear"].scene,
        code=[*modules("section_5_3"), *PLOTTING],
        references=REFERENCES,
    output:
        fig11=figure(11, SHEAR),
        fig11_data="results/paper/fig11.nc",
        fig12=figure(12, SHEAR),
        fig12_data="results/paper/fig12.nc",
    log:
        "results/logs/section_5_3.log",
    benchmark:
        "results/benchmarks/section_5_3.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Section 5.3: figures 11 and 12"
    script:
        "jobs/section_5_3.py"


rule section_5_4:
    input:
        growth=GROWN["holes"],
        scene=STUDIES["holes"].scene,
        code=[*modules("section_5_4"), *PLOTTING],
        references=REFERENCES,
    output:
        fig13=figure(13, HOLES),
        fig13_data="results/paper/fig13.nc",
        fig14=figure(14, HOLES),
        fig14_data="results/paper/fig14.nc",
    log:
        "results/logs/section_5_4.log",
    benchmark:
        "results/benchmarks/section_5_4.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    message:
        "Section 5.4: figures 13 and 14"
    script:
        "jobs/section_5_4.py"


rule section_5_5:
    input:
        growth=GROWN["beam"],
        scene=STUDIES["beam"].scene,
        code=[*modules("section_5_5"), *PLOTTING],
        references=REFERENCES,
    output:
        fig15=figure(15, BEAM),
        fig15_data="results/paper/fig15.nc",
        fig16=figure(16, BEAM),
        fig16_data="results/paper/fig16.nc",
    log:
        "results/logs/section_5_5.log",
    benchmark:
        "results/benchmarks/section_5_5.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=5,
    params:
        sizes=SETTINGS.growth.near_miss_sizes(),
    message:
        "Section 5.5: figures 15 and 16"
    script:
        "jobs/section_5_5.py"


rule claims_growth:
    input:
        **GROWN,
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
