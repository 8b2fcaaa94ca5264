from workflows.job import job
from workflows.paper.section_5_1 import write_grids

with job(snakemake):
    write_grids(snakemake.input.scene, snakemake.params.meshes, snakemake.output.data)
