from workflows.job import job
from workflows.performance.figures import draw_work_precision

with job(snakemake):
    draw_work_precision(snakemake.input.data, snakemake.output.picture)
