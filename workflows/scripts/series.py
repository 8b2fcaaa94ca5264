from workflows.job import job
from workflows.paper.section_5_1 import write_series

with job(snakemake):
    write_series(
        snakemake.input.scene,
        snakemake.params.meshes,
        snakemake.params.radii,
        snakemake.output.data,
    )
