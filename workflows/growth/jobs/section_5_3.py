from workflows.execution.job import job
from workflows.growth.figures import write_fig11, write_fig12

with job(snakemake):
    growth, out = snakemake.input.growth, snakemake.output
    write_fig11(growth, snakemake.input.scene, out.fig11, out.fig11_data)
    write_fig12(growth, out.fig12, out.fig12_data)
