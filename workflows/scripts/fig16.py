from workflows.job import job
from workflows.paper.figures_growth import write_fig16

with job(snakemake):
    write_fig16(
        snakemake.input.growth, snakemake.input.scene, **snakemake.params, **snakemake.output
    )
