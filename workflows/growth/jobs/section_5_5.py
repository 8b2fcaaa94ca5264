from workflows.execution.job import job
from workflows.growth.figures import write_fig15, write_fig16

with job(snakemake):
    growth, scene, out = snakemake.input.growth, snakemake.input.scene, snakemake.output
    write_fig15(growth, scene, out.fig15, out.fig15_data)
    write_fig16(growth, scene, snakemake.params.sizes, out.fig16, out.fig16_data)
