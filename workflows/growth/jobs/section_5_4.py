from workflows.execution.job import job
from workflows.growth.holes_figures import (
    write_driving_force_holes,
    write_fig13,
    write_fig14,
    write_scatter_holes,
)

with job(snakemake):
    growth, scene, out = snakemake.input.growth, snakemake.input.scene, snakemake.output
    variants = snakemake.params.variants
    write_fig13(growth, scene, variants, out.fig13, out.fig13_data)
    write_fig14(growth, scene, variants, out.fig14, out.fig14_data)
    write_driving_force_holes(growth, scene, out.force, out.force_data)
    write_scatter_holes(snakemake.input.scatter, scene, out.scattered, out.scattered_data)
