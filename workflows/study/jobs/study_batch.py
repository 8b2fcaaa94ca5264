from cfmpm.study.batches import write_batch
from workflows.execution.job import job

# The processes that solve members load this file too.
if __name__ == "__main__":
    with job(snakemake):
        write_batch(
            snakemake.params.file,
            snakemake.params.members,
            snakemake.threads,
            snakemake.output.data,
            last=bool(snakemake.resources.last),
        )
