from workflows.execution.job import job
from workflows.performance.work_precision import measure

# The process that solves the members loads this file too.
if __name__ == "__main__":
    with job(snakemake):
        measure(snakemake.output.data, **snakemake.params)
