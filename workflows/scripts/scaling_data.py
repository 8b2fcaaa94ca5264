from workflows.job import job
from workflows.performance.scaling import measure

with job(snakemake):
    measure(path=snakemake.output.data, **snakemake.params)
