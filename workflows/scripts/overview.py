from workflows.job import job
from workflows.paper.overview import write_overview

with job(snakemake):
    write_overview(**snakemake.params, page=snakemake.output.page)
