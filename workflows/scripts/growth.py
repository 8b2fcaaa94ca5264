from workflows.job import job
from workflows.paper.growth import write_growth

with job(snakemake):
    write_growth(snakemake.input.scene, snakemake.params.variants, snakemake.output.data)
