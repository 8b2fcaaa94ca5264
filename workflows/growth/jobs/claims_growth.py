from workflows.execution.job import job
from workflows.growth.claims import write_claims

with job(snakemake):
    write_claims(dict(snakemake.input), **snakemake.output)
