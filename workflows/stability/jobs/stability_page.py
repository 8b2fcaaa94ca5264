from workflows.execution.job import job
from workflows.stability.page import write_page

with job(snakemake):
    write_page(snakemake.input.data, snakemake.params.titles, **snakemake.output)
