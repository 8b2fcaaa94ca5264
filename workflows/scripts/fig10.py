from workflows.job import job
from workflows.paper.figures_growth import write_fig10

with job(snakemake):
    write_fig10(snakemake.input.growth, snakemake.input.scene, **snakemake.output)
