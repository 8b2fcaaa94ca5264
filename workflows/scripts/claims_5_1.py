from workflows.job import job
from workflows.paper.claims_5_1 import write_claims

with job(snakemake):
    write_claims(
        dict(snakemake.input), snakemake.input.scene, **snakemake.params, **snakemake.output
    )
