from workflows.execution.job import job
from workflows.overview.page import write_overview

with job(snakemake):
    write_overview(**snakemake.params, **snakemake.output)
