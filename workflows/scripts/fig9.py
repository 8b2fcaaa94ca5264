from workflows.job import job
from workflows.paper.figures_growth import write_fig9

with job(snakemake):
    write_fig9(snakemake.input.growth, **snakemake.output)
