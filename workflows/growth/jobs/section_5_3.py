from workflows.execution.job import job
from workflows.growth.shear_figures import (
    write_convergence_shear,
    write_fig11,
    write_fig12,
    write_scatter_shear,
)

with job(snakemake):
    growth, scene, out = snakemake.input.growth, snakemake.input.scene, snakemake.output
    variants = snakemake.params.variants
    write_fig11(growth, scene, variants, out.fig11, out.fig11_data)
    write_fig12(growth, scene, variants, out.fig12, out.fig12_data)
    write_convergence_shear(growth, out.convergence, out.convergence_data)
    write_scatter_shear(snakemake.input.scatter, scene, out.scattered, out.scattered_data)
