from workflows.job import job
from workflows.paper.claims_growth import write_claims

with job(snakemake):
    write_claims(dict(snakemake.input), **snakemake.output)
