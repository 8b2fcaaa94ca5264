from workflows.execution.job import job
from workflows.growth.beam_figures import (
    write_fig15,
    write_fig16,
    write_near_miss_beam,
    write_scatter_beam,
)

with job(snakemake):
    growth, scene, out = snakemake.input.growth, snakemake.input.scene, snakemake.output
    variants, sizes = snakemake.params.variants, snakemake.params.sizes
    write_fig15(growth, scene, variants, out.fig15, out.fig15_data)
    write_fig16(growth, scene, variants, out.fig16, out.fig16_data)
    write_near_miss_beam(growth, scene, sizes, out.near_miss, out.near_miss_data)
    write_scatter_beam(snakemake.input.scatter, scene, variants, out.scattered, out.scattered_data)
