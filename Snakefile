include: "workflows/Snakefile"


# `snakemake` alone reproduces the paper; workflows/Snakefile names the other targets.
rule all:
    input:
        REPRODUCED,
