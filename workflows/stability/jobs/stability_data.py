from workflows.execution.job import job
from workflows.stability.cases import write_cases

# The processes that solve members load this file too.
if __name__ == "__main__":
    with job(snakemake):
        write_cases(snakemake.params.settings, snakemake.threads, snakemake.output.data)
