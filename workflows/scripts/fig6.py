from workflows.job import job
from workflows.paper.figures_5_1 import write_fig6

with job(snakemake):
    write_fig6(
        snakemake.input.series, snakemake.input.grids, **snakemake.params, **snakemake.output
    )
