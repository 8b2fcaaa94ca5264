from workflows.execution.job import job
from workflows.growth.datasets import write_growth

with job(snakemake):
    write_growth(snakemake.input.scene, snakemake.params.variants, snakemake.output.data)
