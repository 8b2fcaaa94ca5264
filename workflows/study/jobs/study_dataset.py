from cfmpm.study.batches import write_study
from workflows.execution.job import job

with job(snakemake):
    write_study(snakemake.params.file, snakemake.input.parts, snakemake.output.data)
