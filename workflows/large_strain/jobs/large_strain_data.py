from workflows.execution.job import job
from workflows.large_strain.datasets import write_large_strain

# The processes that solve members load this file too.
if __name__ == "__main__":
    with job(snakemake):
        write_large_strain(snakemake.input.study, snakemake.threads, snakemake.output.data)
