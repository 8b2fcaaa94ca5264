from workflows.execution.job import job
from workflows.growth.figures import write_fig9, write_fig10

with job(snakemake):
    growth, out = snakemake.input.growth, snakemake.output
    write_fig9(growth, out.fig9, out.fig9_data)
    write_fig10(growth, snakemake.input.scene, out.fig10, out.fig10_data)
