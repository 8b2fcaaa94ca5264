from workflows.execution.job import job
from workflows.growth.film import write_film

with job(snakemake):
    write_film(snakemake.input.scene, **snakemake.params.film, **snakemake.output)
