from workflows.job import job
from workflows.paper.figures_5_1 import write_fig7

with job(snakemake):
    write_fig7(dict(snakemake.input), **snakemake.params, **snakemake.output)
