from workflows.job import job
from workflows.paper.figures_growth import write_fig15

with job(snakemake):
    write_fig15(snakemake.input.growth, snakemake.input.scene, **snakemake.output)
