from workflows.job import job
from workflows.paper.figures_growth import write_fig14

with job(snakemake):
    write_fig14(snakemake.input.growth, **snakemake.output)
