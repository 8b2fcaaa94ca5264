from workflows.execution.job import job
from workflows.performance.scaling import measure

with job(snakemake):
    measure(snakemake.output.data, snakemake.input.scene, **snakemake.params)
