from workflows.execution.job import job
from workflows.section_5_1.datasets import write_datasets
from workflows.section_5_1.settings import SERIES

with job(snakemake):
    out = snakemake.output
    write_datasets(
        snakemake.input.study,
        snakemake.input.scene,
        snakemake.params.drawn,
        series={name: out[name] for name in SERIES},
        grids=out.grids,
    )
