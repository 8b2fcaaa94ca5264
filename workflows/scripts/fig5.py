from workflows.job import job
from workflows.paper.figures_5_1 import write_fig5

with job(snakemake):
    write_fig5(snakemake.input.series, **snakemake.params, **snakemake.output)
