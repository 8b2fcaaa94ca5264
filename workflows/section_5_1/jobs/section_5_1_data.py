from workflows.execution.job import job
from workflows.section_5_1.datasets import write_datasets
from workflows.section_5_1.settings import SERIES

# The processes that solve members load this file too.
if __name__ == "__main__":
    with job(snakemake):
        out = snakemake.output
        write_datasets(
            snakemake.input.study,
            snakemake.params.drawn,
            snakemake.threads,
            series={name: out[name] for name in SERIES},
            grids=out.grids,
        )
