from workflows.job import job
from workflows.paper.film import write_film

with job(snakemake):
    write_film(snakemake.input.scene, **snakemake.params.film, path=snakemake.output.film)
