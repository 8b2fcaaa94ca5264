from workflows.job import job
from workflows.paper.figures_growth import write_fig12

with job(snakemake):
    write_fig12(snakemake.input.growth, **snakemake.output)
