from workflows.job import job
from workflows.paper.large_strain import write_large_strain

with job(snakemake):
    write_large_strain(snakemake.input.scene, snakemake.params.variants, snakemake.output.data)
