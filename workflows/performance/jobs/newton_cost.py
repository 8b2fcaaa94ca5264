from workflows.execution.job import job
from workflows.performance.newton_cost import measure

with job(snakemake):
    measure(snakemake.output.data, snakemake.input.scene, **snakemake.params)
