from workflows.execution.job import job
from workflows.large_strain.datasets import write_large_strain

with job(snakemake):
    write_large_strain(snakemake.input.scene, snakemake.params.variants, snakemake.output.data)
