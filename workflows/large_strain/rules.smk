# Fig. 8 of the paper: the plate of section 5.1 pulled to twice its length.

LARGE = "5.1 Large strain"
contribute(
    LARGE,
    {
        8: (
            "CF against elongation",
            "CF up to an elongation of 50 % beside an analytical solution",
        )
    },
    {"computation": ["large_strain_data"], "figures": ["large_strain"]},
    SETTINGS.large_strain,
)


rule large_strain_data:
    input:
        study=SETTINGS.large_strain.study,
        scene=SETTINGS.large_strain.scene,
        compiled=rules.warm_up.output.stamp,
        code=modules("large_strain_data", "ellipticity"),
    output:
        data="results/paper/large_strain/curves.nc",
    log:
        "results/logs/large_strain_data.log",
    benchmark:
        "results/benchmarks/large_strain_data.tsv"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    message:
        "Fig. 8: the plate pulled, by formulation, law and grid"
    script:
        "jobs/large_strain_data.py"


rule large_strain:
    input:
        data=rules.large_strain_data.output.data,
        references=REFERENCES,
        code=[*modules("large_strain"), *PLOTTING],
    output:
        fig8=figure(8, LARGE),
        fig8_data="results/paper/fig8.nc",
        table="results/paper/large_strain.csv",
        markdown="results/paper/large_strain.md",
        page=claims(
            "results/paper/large_strain.html",
            "report/claims.rst",
            LARGE,
        ),
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
