from workflows.job import job
from workflows.paper.figures_growth import write_fig13

with job(snakemake):
    write_fig13(snakemake.input.growth, snakemake.input.scene, **snakemake.output)
