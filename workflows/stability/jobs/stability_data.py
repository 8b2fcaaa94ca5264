from workflows.execution.job import job
from workflows.stability.cases import write_cases

with job(snakemake):
    write_cases(snakemake.params.settings, snakemake.output.data)
