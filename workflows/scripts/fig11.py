from workflows.job import job
from workflows.paper.figures_growth import write_fig11

with job(snakemake):
    write_fig11(snakemake.input.growth, snakemake.input.scene, **snakemake.output)
