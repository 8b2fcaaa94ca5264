from workflows.execution.job import job
from workflows.growth.datasets import write_growth

# The processes that solve members load this file too.
if __name__ == "__main__":
    with job(snakemake):
        write_growth(snakemake.input.study, snakemake.threads, snakemake.output.data)
