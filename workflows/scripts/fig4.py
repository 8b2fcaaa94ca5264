from workflows.job import job
from workflows.paper.figures_5_1 import write_fig4

with job(snakemake):
    write_fig4(snakemake.input.grids, **snakemake.params, **snakemake.output)
