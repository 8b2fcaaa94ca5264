from workflows.execution.job import job
from workflows.performance.study_overhead import measure

with job(snakemake):
    measure(snakemake.output.data, snakemake.input.scene, **snakemake.params)
