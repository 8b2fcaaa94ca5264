from workflows.execution.job import job
from workflows.performance.figures import draw_scaling

with job(snakemake):
    draw_scaling(snakemake.input.data, snakemake.output.picture)
