from workflows.execution.job import job
from workflows.section_5_1.datasets import write_grids, write_series

with job(snakemake):
    scene, series = snakemake.input.scene, snakemake.params.series
    for name, meshes in series.items():
        write_series(scene, meshes, snakemake.params.radii, snakemake.output[name])
    write_grids(scene, snakemake.params.grids, snakemake.output.grids)
