from workflows.execution.job import job
from workflows.growth.figures import write_fig13, write_fig14

with job(snakemake):
    growth, out = snakemake.input.growth, snakemake.output
    write_fig13(growth, snakemake.input.scene, out.fig13, out.fig13_data)
    write_fig14(growth, out.fig14, out.fig14_data)
