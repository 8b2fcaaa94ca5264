from workflows.execution.job import job
from workflows.performance.work_precision import measure

with job(snakemake):
    measure(snakemake.output.data, **snakemake.params)
